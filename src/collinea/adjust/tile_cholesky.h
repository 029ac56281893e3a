// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "collinea/adjust/tile_kernels.h"
#include "collinea/base/run.h"

namespace collinea::bundle {

/// A symmetric positive definite matrix in tiles of kTile x kTile under an envelope: tile row i holds the tiles from
/// its first non-zero one to the diagonal, side by side, by columns. Cholesky's factor fills the same envelope, so
/// nothing is ever moved. Unused rows at the end are ones on the diagonal.
class TileCholesky {
 public:
  /// `first_tile[i]`: the first tile of tile row i, at most i.
  TileCholesky(int size, std::vector<int> first_tile);

  [[nodiscard]] int size() const { return size_; }
  [[nodiscard]] int tile_rows() const { return static_cast<int>(first_.size()); }
  [[nodiscard]] int first_tile(int row) const { return first_[row]; }
  /// The tile of a row; column from first_tile(row) to row.
  [[nodiscard]] double* tile(int row, int column) { return tiles_.data() + offset(row, column); }
  [[nodiscard]] const double* tile(int row, int column) const { return tiles_.data() + offset(row, column); }
  /// An element of the lower triangle under the envelope.
  [[nodiscard]] double& at(int row, int column) {
    return tile(row / kTile, column / kTile)[column % kTile * kTile + row % kTile];
  }

  void clear();  ///< all zero, ones in the unused rows
  /// Replaces the lower triangle by its Cholesky factor. False when the matrix is not positive definite: a pivot is not
  /// above `least_pivot` times its diagonal element; `failed_row` then tells which.
  [[nodiscard]] bool factor(const Run& run, double least_pivot = 0);
  [[nodiscard]] int failed_row() const { return failed_row_; }
  /// Solves in place, after factor. x has at least tile_rows() * kTile elements, zero beyond size().
  void solve(double* x) const;
  /// Replaces the factor by the elements of the inverse under the envelope (Takahashi et al. 1973), after factor.
  void invert();

 private:
  [[nodiscard]] std::size_t offset(int row, int column) const {
    return (row_begin_[row] + static_cast<std::size_t>(column - first_[row])) * kTileSize;
  }
  [[nodiscard]] bool factor_diagonal(int row, double least_pivot);

  int size_ = 0, failed_row_ = -1;
  std::vector<int> first_;
  std::vector<std::size_t> row_begin_;
  std::vector<double> tiles_;
  std::vector<double> diagonal_inverses_;  // of the factor's diagonal tiles
};

}  // namespace collinea::bundle
