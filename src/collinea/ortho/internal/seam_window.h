// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "collinea/ortho/internal/ortho_scene.h"

namespace collinea {

/// What is to be weighed where a seam may run: a window of the coarse grid of seams, its views, and what each of them
/// costs and shows in each cell. Prices are in kPrice per unit of seam energy.
class SeamWindow {
 public:
  static constexpr int kCoarse = 4;  ///< cells of the orthophoto along a cell of the plan
  static constexpr int kBlock = OrthoPatch::kBlock;
  static constexpr int kPrice = 256;
  static constexpr int kForbidden = std::numeric_limits<int>::max();
  static constexpr int kMostDifferent =
      30;  ///< [grey levels]: images that differ by more differ, no matter by how much

  /// A view in a cell.
  struct Choice {
    int price = kForbidden;  ///< of showing the cell from this view; kForbidden: the view does not show it
    std::array<std::uint8_t, 3> colour{};
    bool has_colour = false;
  };
  struct Block {
    std::vector<std::int16_t> views;                     ///< worth a look, ascending
    std::vector<Choice> choices;                         ///< [view][cell], rows first
    [[nodiscard]] int slot_of(std::int16_t view) const;  ///< -1: not among them
  };

  SeamWindow(int blocks_across, int blocks_down);

  [[nodiscard]] int width() const { return across_ * kBlock; }
  [[nodiscard]] int height() const { return down_ * kBlock; }
  [[nodiscard]] int blocks_across() const { return across_; }
  [[nodiscard]] int blocks_down() const { return down_; }
  [[nodiscard]] Block& block(int i, int j) { return blocks_[std::size_t(j * across_ + i)]; }
  [[nodiscard]] const Block& block(int i, int j) const { return blocks_[std::size_t(j * across_ + i)]; }
  /// Null when the view is none of its block's.
  [[nodiscard]] const Choice* choice(int x, int y, std::int16_t view) const;
  /// How much two views differ in a cell: 0 to 1, and 1 where one of them (null: not there) shows nothing. A metric.
  [[nodiscard]] static float difference(const Choice* a, const Choice* b);
  /// What a seam costs through the side between two neighbouring cells, of two views that differ by the mean of
  /// `different` in these. A metric of the views too: never cheaper by way of a third one.
  [[nodiscard]] int seam_price(int x, int y, int u, int v, float different) const;

  FloatImage raised;  ///< per cell: 0 on the terrain to 1 on what stands well above it
  FloatImage steep;   ///< per cell: 0 on level ground to 1 at steps of the surface

 private:
  int across_, down_;
  std::vector<Block> blocks_;
};

/// Where the view that is `source` of a plan (its number + 1, 0: none) stands in `views`, ascending; kNoView: nowhere.
[[nodiscard]] std::int16_t index_of_source(const std::vector<std::size_t>& views, std::uint16_t source);

/// How a window is looked at.
struct SeamLook {
  double cell_m = 0;           ///< of the orthophoto that is planned
  double raised_m = 0;         ///< what stands so much above the terrain is raised in full
  std::size_t best_views = 8;  ///< worth a look at the corner of a block
  /// Null, or a plan of cells `start_times` as large: what it has around a block is worth a look there, too.
  const Raster<std::uint16_t>* start = nullptr;
  int start_times = 1;

  /// 1 + index of the scene's view that the start has in a cell of the window's grid; 0: none.
  [[nodiscard]] std::uint16_t started(int column, int row) const {
    const int x = column / start_times, y = row / start_times;
    return column >= 0 && row >= 0 && x < start->width && y < start->height ? start->at(x, y) : std::uint16_t{0};
  }
};

/// Looks at a part of the coarse scene (whole blocks of its grid); `views`: of the scene, in the order of the indices
/// in the window. Nothing where no view shows anything. `coarse.terrain` may be missing. Errors: an image or the
/// surface cannot be read; cancelled.
[[nodiscard]] Result<std::optional<SeamWindow>> look_at(const OrthoScene& coarse, const SeamLook& look,
                                                        const CellArea& area, std::vector<std::size_t>& views,
                                                        const Run& run);

/// The labelling of least energy within reach of alpha-expansions (Boykov, Veksler, Zabih 2001), from `labels` on
/// (kNoView stays). Only cells in [first, last) of both axes may change.
void cut_seams(const SeamWindow& window, int first_x, int first_y, int last_x, int last_y,
               Raster<std::int16_t>& labels);

/// The cheapest view of each cell; kNoView where none shows it.
[[nodiscard]] Raster<std::int16_t> cheapest_views(const SeamWindow& window);

}  // namespace collinea
