// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "collinea/base/id.h"
#include "collinea/base/parallel_in_order.h"
#include "collinea/base/result.h"
#include "collinea/base/run.h"
#include "collinea/base/words.h"

namespace collinea {

// Units of work: a step lists what it has to do, and the functions below go through the list. The list is what resumes
// (units whose result exists are kept), what progress counts, and what other machines could be asked for.

enum class UnitKind : std::uint8_t { kFile, kImage, kOverview, kDepthMap, kPair, kTile, kWindow };

inline constexpr Word<UnitKind> kUnitKindWords[] = {
    {UnitKind::kFile, "file"},          {UnitKind::kImage, "image"}, {UnitKind::kOverview, "overview"},
    {UnitKind::kDepthMap, "depth map"}, {UnitKind::kPair, "pair"},   {UnitKind::kTile, "tile"},
    {UnitKind::kWindow, "window"},
};
constexpr std::span<const Word<UnitKind>> words(UnitKind) { return kUnitKindWords; }

/// The smallest piece of work that is done as a whole or not at all. Its kind and numbers mean the same to every
/// process that opens the project. Within a list no two units are equal.
struct Unit {
  UnitKind kind;
  std::int64_t first = 0;   ///< index of a file in the sorted list; id of an image, of the first one of a pair; column
  std::int64_t second = 0;  ///< id of the second image of a pair; row; otherwise 0

  [[nodiscard]] static Unit file(std::size_t index) { return {UnitKind::kFile, std::int64_t(index)}; }
  [[nodiscard]] static Unit of(UnitKind kind, ImageId image) { return {kind, std::int64_t{image.value}}; }
  [[nodiscard]] static Unit pair(ImageId first, ImageId second) {
    return {UnitKind::kPair, std::int64_t{first.value}, std::int64_t{second.value}};
  }
  /// `column` and `row` count tiles, not cells.
  [[nodiscard]] static Unit tile(std::int64_t column, std::int64_t row) { return {UnitKind::kTile, column, row}; }
  /// `column` and `row`: the upper-left cell of an area that lies on no grid of tiles.
  [[nodiscard]] static Unit window(std::int64_t column, std::int64_t row) { return {UnitKind::kWindow, column, row}; }

  /// The image that a unit of one image is about.
  [[nodiscard]] ImageId image() const { return ImageId{static_cast<std::uint32_t>(first)}; }

  friend auto operator<=>(const Unit&, const Unit&) = default;
};

/// "depth map 12", "pair 3-7", "tile 4,-2".
[[nodiscard]] std::string name_of(const Unit& unit);

/// What a step has to do, or a part of it, in the order in which it is begun.
struct UnitList {
  std::string stage;  ///< by which progress calls it: "detect", "densify: overviews"
  std::vector<Unit> units;
  double begin = 0, end = 1;  ///< what part of the stage's progress the list is
};

/// The tiles of a raster of `width` x `height` cells, row by row; the last of a row or column may be smaller.
[[nodiscard]] std::vector<Unit> tiles_over(std::int64_t width, std::int64_t height, std::int64_t tile_width,
                                           std::int64_t tile_height);

/// Progress of a list: reports how many of the `remaining` units are finished, as the part of the stage that the list
/// is. Never falls, and is the list's end when all are finished, or none remains. For several threads.
class UnitProgress {
 public:
  /// Refers to `run` and `list`.
  UnitProgress(const Run& run, const UnitList& list, std::size_t remaining);
  void finish_one();

 private:
  const Run& run_;
  const UnitList& list_;
  std::size_t remaining_, finished_ = 0;
  std::mutex mutex_;
};

/// How a unit ended. Skipped: it has no result, by its own fault (an image that cannot be read).
enum class UnitEnd : std::uint8_t { kNotDone, kKept, kMade, kSkipped };

struct UnitsDone {
  std::vector<UnitEnd> ends;                     ///< by index in the list
  std::map<std::size_t, Error> skipped_because;  ///< by index in the list

  [[nodiscard]] std::size_t count(UnitEnd end) const;
};

/// What work on a unit came to.
struct UnitWorked {
  std::optional<Error> skipped_because = {};  ///< nothing: its result is there
};

/// What is to be done for the units of a list, each named by its index there.
struct UnitJob {
  /// Whether the result of a unit exists from an earlier run. Empty: none does. Asked in the order of the list, before
  /// any work begins.
  std::function<bool(std::size_t unit)> is_done = {};
  /// Makes the result of a unit, and keeps it unless `keep` does that. Called from several threads, with a run of one
  /// thread and without progress. An error is one that other units would meet, too (a full disk): it ends the list.
  std::function<Result<UnitWorked>(std::size_t unit, const Run& run)> work;
  std::size_t batch = 0;  ///< so many units are kept at a time; 0: all
  std::function<Result<>()> keep =
      {};  ///< keeps what a batch has made; also when the run is stopped within it, or a unit ends the list
};

/// Works on those units of a list that have no result yet, side by side on run.threads threads: better use of the
/// processor than threads within one. Progress counts what remained at the start. Errors: the first in the order of the
/// list that `work` met, with the unit's name in front, unless the run was stopped; of `keep`; cancelled.
[[nodiscard]] Result<UnitsDone> run_units(const Run& run, const UnitList& list, const UnitJob& job);

/// Logs how many units of a step had been made before; nothing when none had.
void say_kept(const Run& run, std::string_view stage, UnitKind kind, std::size_t kept, std::size_t all);
void say_kept(const Run& run, const UnitList& list, const UnitsDone& done);

/// Works on units one after the other, each with all threads. Ends with the first error. Errors besides: cancelled.
[[nodiscard]] Result<> run_units_one_by_one(const Run& run, const UnitList& list,
                                            const std::function<Result<>(const Unit&)>& work);

/// Units that are parts of one product: make(unit) side by side, take(unit, what was made) in the order of the list, as
/// parallel_in_order does. The product is made as a whole or not at all, so none of them is kept from before.
template <class Make, class Take>
[[nodiscard]] Result<> run_units_in_order(const Run& run, const UnitList& list, const Make& make, const Take& take) {
  UnitProgress progress(run, list, list.units.size());
  return parallel_in_order(
      run, list.units.size(), [&](std::size_t i) { return make(list.units[i]); },
      [&](std::size_t i, auto made) -> Result<> {
        Result<> taken = take(list.units[i], std::move(made));
        if (taken) progress.finish_one();
        return taken;
      });
}

}  // namespace collinea
