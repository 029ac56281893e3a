// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "collinea/raster/raster.h"

namespace collinea {

/// One level of a pyramid of heights: cell (i, j) of it covers cells 2i, 2i + 1 by 2j, 2j + 1 of the next finer one,
/// all counted from the same origin as the cells of the raster, so that windows of one raster agree.
struct HeightLevel {
  std::int64_t column = 0, row = 0;  ///< of its upper-left cell, in cells of this level
  double cell_m = 1;                 ///< of this level
  double step_m = 0;                 ///< heights that differ by less belong to one surface
  FloatImage height_m, sigma_m;
  FloatImage weight;  ///< cells of the raster that made it; 0: nothing known, or filled in from coarser levels

  HeightLevel() = default;
  HeightLevel(std::int64_t first_column, std::int64_t first_row, int width, int height, double cell, double step);
};

/// The level of a whole raster of heights that count as exact; NaN: nothing there.
[[nodiscard]] HeightLevel level_of(FloatImage heights_m, double cell);

/// The next coarser level. Of four cells the lowest counts, together with those that a slope joins to it: where roof
/// and ground meet it is the ground. Levels that hold less than a tenth of the weight are taken for wrong.
[[nodiscard]] HeightLevel coarser(const HeightLevel& fine);

/// Gives every cell of weight 0 a height: bilinear from the coarse level, the lowest surface again, then smoothed. All
/// cells of `coarse` have heights. A cell depends on coarse cells next to its own and on kSmoothings cells around it.
/// sigma_m grows with the distance from what is known.
void fill_from(const HeightLevel& coarse, HeightLevel& fine);
constexpr int kSmoothings = 3;

/// Fills a whole pyramid that starts with this level (Gortler et al. 1996, pull-push; the choice of the lowest surface
/// is not theirs). Nothing happens when no cell has weight. Beside the level its coarser ones take a third of its
/// memory.
void fill_all(HeightLevel& finest);

/// A whole raster of heights that count as exact, with heights in place of NaN: the lowest surface around goes on.
/// kNoHeight when there is none at all. Memory: 16 bytes for each cell, the heights themselves with them.
[[nodiscard]] FloatImage filled(FloatImage heights_m, double cell_m);

}  // namespace collinea
