// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "collinea/math/tile_kernels.h"

namespace collinea::bundle {

/// Which tiles below the diagonal of a symmetric matrix hold something: of each tile row, its columns in any order.
using TilePattern = std::vector<std::vector<int>>;

/// The lower triangle of a sparse symmetric matrix in tiles of kTile x kTile. Only those of the pattern and the
/// diagonal ones are kept; nothing is ever moved. The tiles of a row lie side by side, by columns. Unused rows at the
/// end are ones on the diagonal.
class TileMatrix {
 public:
  static constexpr std::size_t kNowhere = ~std::size_t{0};

  /// `pattern` has a row for every tile row; diagonal tiles go without saying.
  TileMatrix(int size, const TilePattern& pattern);

  [[nodiscard]] int size() const { return size_; }
  [[nodiscard]] int tile_rows() const { return static_cast<int>(row_begin_.size()) - 1; }
  [[nodiscard]] std::size_t tile_count() const { return columns_.size(); }
  /// The columns of a tile row, ascending; the last is the diagonal.
  [[nodiscard]] std::span<const int> columns(int row) const {
    return {columns_.data() + row_begin_[row], columns_.data() + row_begin_[row + 1]};
  }
  /// Indices of tiles: of the first and of the diagonal one of a row, and of any one (kNowhere: not stored).
  [[nodiscard]] std::size_t first(int row) const { return row_begin_[row]; }
  [[nodiscard]] std::size_t diagonal(int row) const { return row_begin_[row + 1] - 1; }
  [[nodiscard]] std::size_t find(int row, int column) const;
  [[nodiscard]] int column_of(std::size_t index) const { return columns_[index]; }
  [[nodiscard]] const double* tile(std::size_t index) const { return tiles_.data() + index * kTileSize; }
  [[nodiscard]] double* tile(std::size_t index) { return tiles_.data() + index * kTileSize; }

  [[nodiscard]] bool holds(int row, int column) const { return find(row, column) != kNowhere; }  ///< tiles
  /// An element of the lower triangle, in a tile that is held.
  [[nodiscard]] double& at(int row, int column);

  void clear();  ///< all zero, ones in the unused rows
  /// y := this * x; both of tile_rows() * kTile elements.
  void times(const double* x, double* y) const;

 private:
  int size_ = 0;
  std::vector<std::size_t> row_begin_;  // of each tile row in columns_ and, times kTileSize, in tiles_
  std::vector<int> columns_;
  std::vector<double> tiles_;
};

}  // namespace collinea::bundle
