// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "collinea/dense/internal/match_kernels.h"
#include "collinea/raster/raster.h"

namespace collinea::dense {

/// The hypotheses of one cell: inverse depth at pixel (x, y), label k is  base(x, y) + (first + k) step.  The base is
/// the smooth surface known so far, or, where that surface breaks, a plane: then windows of comparison are not torn.
struct Cell {
  int left = 0, top = 0;                    ///< index of the upper-left pixel
  bool follows_surface = false;             ///< base = smooth surface; else the plane
  float at_corner = 0, by_x = 0, by_y = 0;  ///< the plane: at_corner + by_x (x - left) + by_y (y - top)
  float first = 0;                          ///< of label 0 [steps]
  int labels = 0;
  int stride = 0;          ///< bytes per pixel in the volume: a guard, the labels, guards; a multiple of 16
  std::size_t offset = 0;  ///< of the cell's pixels in the volume, rows of kCell pixels
};

/// Label k is element k + 1 of a pixel: the first and the last elements are guards.
inline constexpr int kGuard = 1;
inline constexpr int kStrideUnit = 16;
inline constexpr int kMaxLabels = 190;

/// The hypotheses of an image, cell by cell.
struct Labels {
  int width = 0, height = 0;  ///< of the image [px]
  int columns = 0, rows = 0;  ///< of cells
  float step = 0;             ///< inverse depth per label
  FloatImage surface;         ///< the smooth surface: inverse depth at every pixel
  std::vector<Cell> cells;    ///< by rows; offsets are not set yet

  [[nodiscard]] const Cell& cell(int column, int row) const {
    return cells[std::size_t(row) * std::size_t(columns) + std::size_t(column)];
  }
  [[nodiscard]] float base(const Cell& cell, int x, int y) const;  ///< clamped at the border of the image
};

/// Labels around a plane in inverse depth (w = at_corner + by_x x + by_y y), from `low` to `high` steps off it
/// everywhere.
[[nodiscard]] Labels labels_around_plane(int width, int height, float step, float at_corner, float by_x, float by_y,
                                         float low, float high);

/// Labels around the result of the level that is half as large: within each cell from the smallest to the largest
/// inverse depth of the coarse surface there, and `margin` steps more. `coarse`: inverse depths, no NaN.
[[nodiscard]] Labels labels_around(const FloatImage& coarse, int width, int height, float step, int margin);

/// The median of each 3 x 3 pixels; NaN do not count, and stay only where all are NaN.
[[nodiscard]] FloatImage median3(const FloatImage& raster);

/// NaN replaced by a smooth transition between the values around them; all 0 when there is none.
void fill_holes(FloatImage& raster);

/// Half the size (rounded up), by the mean of those of 2 x 2 pixels that are not NaN.
[[nodiscard]] FloatImage halved(const FloatImage& raster);

}  // namespace collinea::dense
