// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "collinea/surface/surface_filter.h"

namespace collinea {

/// A point of the cloud in the cells of a raster without end: column = east / cell, row = -north / cell.
/// Cell (i, j) covers [i, i+1) x [j, j+1).
struct GridPoint {
  double column = 0, row = 0;
  double height_m = 0;
  float sigma_m = 0;
  std::uint32_t unused = 0;  ///< the record has no gaps: it is written to files as it lies in memory
};

/// A rectangle of cells of that raster.
struct CellWindow {
  std::int64_t column = 0, row = 0;  ///< of its upper-left cell
  int width = 0, height = 0;
};

struct Gridding {
  double cell_m = 1;
  int widest_hole_cells = 0;  ///< holes up to this width are filled; 0: none
};

/// How far outside a window points still matter to it [cells].
[[nodiscard]] int margin_cells(const Gridding& gridding);

/// The surface model of a window: CellFit for every cell, then specks removed and small holes filled. `points` are all
/// of the window and its margin, in any order. The result is the same, bit for bit, for every order of the points and
/// for every way to cut the raster into windows.
[[nodiscard]] SurfaceTile grid_window(std::vector<GridPoint> points, const CellWindow& window,
                                      const Gridding& gridding);

}  // namespace collinea
