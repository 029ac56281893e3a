// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "collinea/raster/raster.h"

namespace collinea {

enum class CellState : std::uint8_t { kEmpty = 0, kMeasured = 1, kInterpolated = 2 };

/// A piece of a surface model: rasters of one size. Cells without height hold kNoHeight in height_m and sigma_m.
struct SurfaceTile {
  FloatImage height_m, sigma_m;
  FloatImage sigma_relative_m;  ///< sigma_m without what the orientation adds; empty until that is added
  Raster<std::uint8_t> state;   ///< CellState
  Raster<std::uint16_t> count;  ///< points that made the cell

  SurfaceTile() = default;
  SurfaceTile(int width, int height);
};
constexpr float kNoHeight = -9999;

/// A part of a tile; column and row count from its upper-left cell.
struct TilePart {
  int column, row, width, height;
};
[[nodiscard]] SurfaceTile cropped(const SurfaceTile& tile, const TilePart& part);

/// Smaller patches of cells are speckles.
constexpr int kSmallestPatch = 9;

/// Empties the cells that belong to a patch of fewer than kSmallestPatch cells: a patch is connected (8 neighbours)
/// without a step in height. What a cell becomes depends only on cells up to kSmallestPatch away.
void remove_speckles(SurfaceTile& tile, double cell_m);

}  // namespace collinea
