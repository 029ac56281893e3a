// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "collinea/image/raster.h"

namespace collinea {

enum class CellState : std::uint8_t { kEmpty = 0, kMeasured = 1, kInterpolated = 2 };

/// A piece of a surface model: four rasters of one size. Cells without height hold kNoHeight in height_m and sigma_m.
struct SurfaceTile {
  FloatImage height_m, sigma_m;
  Raster<std::uint8_t> state;   ///< CellState
  Raster<std::uint16_t> count;  ///< points that made the cell

  SurfaceTile() = default;
  SurfaceTile(int width, int height);
};
constexpr float kNoHeight = -9999;

/// Smaller patches of cells are specks.
constexpr int kSmallestPatch = 9;

/// Empties the cells that belong to a patch of fewer than kSmallestPatch cells: a patch is connected (8 neighbours)
/// without a step in height. What a cell becomes depends only on cells up to kSmallestPatch away.
void remove_specks(SurfaceTile& tile, double cell_m);

/// Fills empty cells across which measured cells lie opposite each other, along a row, a column or a diagonal, no
/// more than `widest_cells` apart: linearly between them, or, where they lie on two sides of a step, at the lower one,
/// because it is the ground beside a wall that no image sees. Gaps wider than 16 cells are filled only where they are
/// enclosed: bridged in three of the four directions. What a cell becomes depends only on cells up to widest_cells
/// away.
void fill_holes(SurfaceTile& tile, double cell_m, int widest_cells);

}  // namespace collinea
