// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "collinea/surface/gridding.h"

namespace collinea {

/// Small parts of a cloud that lie apart from the rest, and far below all of it or told by two images alone: mirror
/// images in water and glass, repeated patterns that several images take for the same wrong place, and what two images
/// make of waves and leaves at the rim of a block. Looked for in blocks of kBlock x kBlock cells.
///
/// A part (blocks with at least kFewest points, 8 neighbours) with less than a hundredth of the points of the largest
/// one goes when
/// - its top lies deeper below the lowest of what is around it than that is away: the ground would have to fall by more
///   than 45 degrees all the way. A courtyard between roofs stays, since there is other ground as low around; so do
///   roofs without ground;
/// - or only two images tell it, while more tell most of the largest part: a wrong match of two images is the same in
///   both, and there is no surface that it joins.
class Islands {
 public:
  static constexpr int kBlock = 16;
  static constexpr int kFewest = 16;

  void add(std::span<const GridPoint> points);
  /// To be called once all points are there; keeps of them only which blocks are islands. Returns how many points lie
  /// on these.
  std::uint64_t find(double cell_m);
  [[nodiscard]] bool holds(const GridPoint& point) const;
  /// The points of a window, whole blocks of it, are not there any more.
  void forget(const CellWindow& window);
  /// Once islands are found: the outermost cells with points that lie on none, all included. There must be some.
  struct Bounds {
    std::int64_t west, north, east, south;
  };
  [[nodiscard]] const Bounds& bounds() const { return bounds_; }

 private:
  using Place = std::pair<std::int64_t, std::int64_t>;  // row and column of a block
  struct Block {
    std::uint64_t points = 0, of_two = 0;                             // the second: told by two images alone
    double sum_m = 0;                                                 // of heights
    std::uint8_t west = kBlock, north = kBlock, east = 0, south = 0;  // cells with points, within the block
    int part = -1;
    bool gone = false;
    [[nodiscard]] double mean_m() const { return sum_m / double(points); }
  };
  struct Part {
    std::vector<Place> blocks;
    std::uint64_t points = 0, of_two = 0;
    [[nodiscard]] double share_of_two() const { return double(of_two) / double(points); }
  };
  [[nodiscard]] static Place place_of(const GridPoint& point);
  [[nodiscard]] std::vector<Part> parts();
  [[nodiscard]] bool is_sunken(const Part& part, const std::vector<Part>& parts, double cell_m) const;

  void mark_islands(const std::vector<Part>& parts, double cell_m);
  std::uint64_t keep_gone();

  std::map<Place, Block> blocks_;
  std::set<Place> gone_;
  Bounds bounds_{};
};

}  // namespace collinea
