// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/surface/surface_filter.h"

namespace collinea {

/// A point of the cloud in the cells of a raster without end: column = east / cell, row = -north / cell.
/// Cell (i, j) covers [i, i+1) x [j, j+1).
struct GridPoint {
  double column = 0, row = 0;
  double height_m = 0;
  float sigma_m = 0;
  std::uint32_t images = 0;  ///< that agree on it; 0: unknown. Has no gaps: it is written to files as it is in memory
};

/// A rectangle of cells of that raster.
struct CellWindow {
  std::int64_t column = 0, row = 0;  ///< of its upper-left cell
  int width = 0, height = 0;
};

/// Rounds down, also below zero.
[[nodiscard]] constexpr std::int64_t floor_div(std::int64_t a, std::int64_t b) { return a / b - (a % b < 0); }

/// How points make heights.
struct Gridding {
  double cell_m;
  double alike_cells = 0;  ///< over which their errors are alike (share_alike)
};

/// How far outside a window points still matter to it [cells].
[[nodiscard]] int margin_cells();

/// All points of a window, in any order.
using PointsOf = std::function<Result<std::vector<GridPoint>>(const CellWindow& window)>;

/// The measured surface in a window: CellFit for every cell, then speckles removed. Without any point in the window and
/// its margin: no rasters. Points are asked for in bands of 64 rows and a few more, which are all that is in memory of
/// them. The result is the same, bit for bit, for every order of the points and for every way to cut the
/// raster into windows. Errors: those of `points_of`.
[[nodiscard]] Result<SurfaceTile> measure_window(const PointsOf& points_of, const CellWindow& window,
                                                 const Gridding& gridding);

}  // namespace collinea
