// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>

#include "collinea/base/parallel.h"
#include "collinea/base/result.h"
#include "collinea/base/run.h"
#include "collinea/base/units.h"
#include "collinea/raster/geotiff.h"
#include "collinea/surface/dsm.h"

namespace collinea {

/// A piece of the surface model. What the orientation adds to the errors of neighbours is the same for all: it does not
/// take part in what is ground.
struct SurfacePiece {
  int column = 0, row = 0;  ///< of its upper-left cell
  FloatImage height_m;
  FloatImage sigma_m;  ///< relative; not read for low heights
  Raster<std::uint8_t> state;
};

/// The rasters of a surface model, read piece by piece, of whole coarse cells of `each` cells along.
class SurfacePieces {
 public:
  /// Rasters are compressed in squares of so many cells.
  static constexpr int kSquare = 512;

  [[nodiscard]] static Result<SurfacePieces> open(const DsmFiles& files);

  [[nodiscard]] const MapGrid& grid() const { return height_.grid(); }
  void set_coarse(int each) { each_ = each; }

  [[nodiscard]] Result<SurfacePiece> read_heights(int column, int row, int width, int rows) const;

  [[nodiscard]] Result<> read_sigmas(SurfacePiece& piece) const;

  /// What the orientation adds to the sigmas of a piece as it was read.
  [[nodiscard]] Result<FloatImage> read_added_variance(const SurfacePiece& piece) const;

  /// Calls work(row of coarse cells, piece) for every row of coarse cells in every piece, several at once. Pieces come
  /// column by column: the squares in which one ends and the next begins are still in the cache.
  template <class Work>
  Result<> over_coarse_rows(const Run& run, bool sigmas, double done_before, double done_after, Work&& work) const {
    const int rows = std::max(kLeastCoarseRows, kPieceRows / each_) * each_, columns = piece_columns();
    const int width = grid().width, height = grid().height;
    UnitList list{.stage = "terrain", .begin = done_before, .end = done_after};
    for (int column = 0; column * columns < width; ++column)
      for (int row = 0; row * rows < height; ++row) list.units.push_back(Unit::tile(column, row));
    return run_units_one_by_one(run, list, [&](const Unit& unit) -> Result<> {
      const int column = int(unit.first) * columns, row = int(unit.second) * rows;
      COLLINEA_TRY(SurfacePiece piece,
                   read_heights(column, row, std::min(columns, width - column), std::min(rows, height - row)));
      if (sigmas) COLLINEA_TRY(read_sigmas(piece));
      parallel_for(run, std::size_t((piece.state.height + each_ - 1) / each_),
                   [&](std::size_t i) { work(row / each_ + int(i), std::as_const(piece)); });
      return {};
    });
  }

  /// Calls visit(column of coarse cells) for all of a piece.
  template <class Visit>
  void for_coarse_columns(const SurfacePiece& piece, Visit&& visit) const {
    const int end = (piece.column + piece.state.width + each_ - 1) / each_;
    for (int u = piece.column / each_; u < end; ++u) visit(u);
  }

  /// Calls visit(x, y in the piece) for every measured cell of a coarse cell.
  template <class Visit>
  void for_measured(const SurfacePiece& piece, int u, int v, Visit&& visit) const {
    const Cells cells = cells_of(piece, u, v);
    for (int y = cells.top; y < cells.bottom; ++y)
      for (int x = cells.left; x < cells.right; ++x)
        if (piece.state.at(x, y) == std::uint8_t(CellState::kMeasured)) visit(x, y);
  }

  /// So many measured cells are enough for a coarse cell to count.
  [[nodiscard]] bool enough(std::size_t cells) const { return double(cells) >= kLeastMeasured * each_ * each_; }

 private:
  static constexpr double kLeastMeasured = 0.1;  // of a coarse cell, for it to count
  // Read at a time: a few megabytes, the same for any width.
  static constexpr int kPieceColumns = 4096, kPieceRows = 128;  // about
  static constexpr int kLeastCoarseRows = 4;                    // of a piece: threads share them

  SurfacePieces(GeoTiffReader height, GeoTiffReader sigma, GeoTiffReader sigma_relative, GeoTiffReader state)
      : height_(std::move(height)),
        sigma_(std::move(sigma)),
        sigma_relative_(std::move(sigma_relative)),
        state_(std::move(state)) {}

  // The cells of a coarse cell in a piece.
  struct Cells {
    int left, top, right, bottom;
  };
  [[nodiscard]] Cells cells_of(const SurfacePiece& piece, int u, int v) const {
    const int left = u * each_ - piece.column, top = v * each_ - piece.row;
    return {left, top, std::min(left + each_, piece.state.width), std::min(top + each_, piece.state.height)};
  }
  // Columns of pieces of whole coarse cells: of whole squares, too, where that is possible, so that none is unpacked
  // for two of them.
  [[nodiscard]] int piece_columns() const;

  GeoTiffReader height_, sigma_, sigma_relative_, state_;
  int each_ = 1;  // cells of the surface model along a coarse one
};

}  // namespace collinea
