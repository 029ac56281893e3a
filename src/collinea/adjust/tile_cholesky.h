// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "collinea/adjust/tile_kernels.h"
#include "collinea/base/run.h"

namespace collinea::bundle {

/// Which tiles below the diagonal of a symmetric matrix hold something: of each tile row, its columns.
using TilePattern = std::vector<std::vector<int>>;

/// The rows below the diagonal of every column of the Cholesky factor, ascending.
[[nodiscard]] std::vector<std::vector<int>> factor_columns(const TilePattern& pattern);

/// A sparse symmetric positive definite matrix in tiles of kTile x kTile. Only those tiles are kept that hold something
/// in the matrix or in its Cholesky factor; nothing is ever moved. The tiles of a row lie side by side, by columns.
/// Unused rows at the end are ones on the diagonal.
class TileCholesky {
 public:
  /// `pattern` has a row for every tile row; diagonal tiles go without saying.
  TileCholesky(int size, const TilePattern& pattern);

  [[nodiscard]] int size() const { return size_; }
  [[nodiscard]] int tile_rows() const { return static_cast<int>(row_begin_.size()) - 1; }
  [[nodiscard]] std::size_t tile_count() const { return columns_.size(); }
  /// The columns of a tile row, ascending; the last is the diagonal.
  [[nodiscard]] std::span<const int> columns(int row) const {
    return {columns_.data() + row_begin_[row], columns_.data() + row_begin_[row + 1]};
  }
  /// The tiles of a row, in the order of columns(row).
  [[nodiscard]] double* tiles(int row) { return tiles_.data() + row_begin_[row] * kTileSize; }
  [[nodiscard]] bool holds(int row, int column) const { return find(row, column) != kNowhere; }  ///< tiles
  /// An element of the lower triangle, in a tile that is held.
  [[nodiscard]] double& at(int row, int column) {
    return tiles_[place(row / kTile, column / kTile) * kTileSize +
                  static_cast<std::size_t>(column % kTile * kTile + row % kTile)];
  }

  void clear();  ///< all zero, ones in the unused rows
  /// Replaces the lower triangle by its Cholesky factor. False when the matrix is not positive definite: a pivot is not
  /// above `least_pivot` times its diagonal element; `failed_row` then tells which.
  [[nodiscard]] bool factor(const Run& run, double least_pivot = 0);
  [[nodiscard]] int failed_row() const { return failed_row_; }
  /// Solves in place, after factor. x has at least tile_rows() * kTile elements, zero beyond size().
  void solve(double* x) const;
  /// Replaces the factor by those elements of the inverse whose tiles are held (Takahashi et al. 1973), after factor.
  void invert(const Run& run);

 private:
  static constexpr std::size_t kNowhere = ~std::size_t{0};
  struct Below {
    int row;
    std::size_t place;
  };

  void lay_out(const TilePattern& pattern);
  void find_subtrees(const std::vector<std::vector<int>>& below);
  [[nodiscard]] std::size_t find(int row, int column) const;
  [[nodiscard]] std::size_t place(int row, int column) const;
  [[nodiscard]] const double* tile(std::size_t place) const { return tiles_.data() + place * kTileSize; }
  [[nodiscard]] double* tile(std::size_t place) { return tiles_.data() + place * kTileSize; }
  [[nodiscard]] std::size_t diagonal(int row) const { return row_begin_[row + 1] - 1; }
  [[nodiscard]] std::span<const Below> below(int column) const {
    return {below_.data() + below_begin_[column], below_.data() + below_begin_[column + 1]};
  }
  [[nodiscard]] int factor_column(int column, double least_pivot, const Run& run);
  [[nodiscard]] int factor_diagonal(int row, double least_pivot);
  void subtract_common(int row, std::size_t row_end, int column);
  void invert_column(int column, const Run& run);

  int size_ = 0, failed_row_ = -1;
  std::vector<std::size_t> row_begin_;  // of each tile row in columns_ and, times kTileSize, in tiles_
  std::vector<int> columns_;
  std::vector<std::size_t> below_begin_;  // of each tile column
  std::vector<Below> below_;
  std::vector<std::vector<int>> subtrees_;  // columns that need only one another, for threads
  std::vector<int> top_;                    // columns after them
  std::vector<double> tiles_;
  std::vector<double> diagonal_inverses_;  // of the factor's diagonal tiles
};

}  // namespace collinea::bundle
