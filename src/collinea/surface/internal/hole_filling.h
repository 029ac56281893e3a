// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "collinea/surface/internal/gridding.h"
#include "collinea/surface/internal/pull_push.h"
#include "collinea/surface/surface_filter.h"

namespace collinea {

/// Finds the holes of a surface model and fills them, window by window. It looks at the whole model first, in blocks of
/// kBlock x kBlock cells: add() every measured tile, then prepare(), then filled() for every window. What a cell
/// becomes does not depend on tiles and windows.
///
/// A hole is what lies inside the block: measured surface on both sides, no farther apart than the widest hole, along
/// at least three of the lines row, column and the two diagonals (steps along a diagonal count as one cell). An area
/// shut in on all sides is filled as a whole when that holds for more than half of it. What would reach out from the
/// surface in strips narrower than nine blocks stays empty. Gaps narrower than kPinhole cells along any of the lines
/// are filled wherever they are. The outline of what is filled is smoothed.
///
/// Heights continue the lowest surface at the rim of a hole (fill_from): beside a building the ground that no image
/// sees.
class HoleFilling {
 public:
  static constexpr int kBlock = 8;
  static constexpr int kPinhole = 16;
  static constexpr int kRim = 3;      ///< margin of the tiles for add(): measured cells so near to a hole are its rim
  static constexpr int kMargin = 48;  ///< of the windows for filled(), a multiple of kBlock

  /// Column, row, width and height: extent of the whole model [cells]. `widest_cells`: widest hole; 0: none are filled.
  HoleFilling(std::int64_t column, std::int64_t row, std::int64_t width, std::int64_t height, double cell_m,
              int widest_cells);

  /// `inside`: a window of whole blocks (its corners on multiples of kBlock); `tile` covers it and kRim cells around.
  /// May be called from several threads at once.
  void add(const SurfaceTile& tile, const CellWindow& inside);
  void prepare();

  /// The window around `inside` for filled(): kMargin more on all sides, corners on multiples of kBlock.
  [[nodiscard]] static CellWindow with_margin(const CellWindow& inside);

  /// The cells of `inside`, of which `tile` is the measured surface with_margin. May be called from several threads.
  [[nodiscard]] SurfaceTile filled(const SurfaceTile& tile, const CellWindow& inside) const;

 private:
  [[nodiscard]] Raster<std::uint8_t> cells_to_fill(const Raster<std::uint8_t>& measured, const CellWindow& wide) const;
  [[nodiscard]] bool shut_in(std::int64_t column, std::int64_t row) const;
  void find_holes();

  double cell_m_;
  int widest_cells_;
  HeightLevel blocks_;            // from the rims
  Raster<std::uint8_t> solid_;    // a quarter of the block is measured
  Raster<std::uint8_t> shut_in_;  // the block lies within the measured surface
};

}  // namespace collinea
