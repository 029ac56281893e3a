// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "collinea/base/run.h"
#include "collinea/math/internal/tile_matrix.h"

namespace collinea::bundle {

/// The rows below the diagonal of every column of the Cholesky factor, ascending.
[[nodiscard]] std::vector<std::vector<int>> factor_columns(const TilePattern& pattern);

/// The Cholesky factor of a sparse symmetric positive definite matrix, and what follows from it. Kept are the tiles
/// that hold something in the factor, which has those of the matrix and more.
class TileCholesky {
 public:
  TileCholesky(int size, const TilePattern& pattern);

  [[nodiscard]] int size() const { return tiles_.size(); }
  [[nodiscard]] int tile_rows() const { return tiles_.tile_rows(); }
  [[nodiscard]] std::size_t tile_count() const { return tiles_.tile_count(); }
  [[nodiscard]] bool holds(int row, int column) const { return tiles_.holds(row, column); }  ///< tiles
  /// An element of the lower triangle, in a tile that is held: of the factor or, after invert, of the inverse.
  [[nodiscard]] double& at(int row, int column) { return tiles_.at(row, column); }
  /// Products of two tiles that factor() takes.
  [[nodiscard]] double work() const { return work_; }

  /// Factors a matrix whose tiles are all held here. False when it is not positive definite: a pivot is not above
  /// `least_pivot` times its diagonal element; `failed_row` then tells which. False, too, when the run was stopped.
  [[nodiscard]] bool factor(const TileMatrix& matrix, const Run& run, double least_pivot = 0);
  [[nodiscard]] int failed_row() const { return failed_row_; }
  /// Solves in place, after factor. x has at least tile_rows() * kTile elements, zero beyond size().
  void solve(double* x) const;
  /// Replaces the factor by those elements of the inverse whose tiles are held (Takahashi et al. 1973), after factor.
  void invert(const Run& run);

 private:
  struct Below {
    int row;
    std::size_t index;
  };

  struct Columns {
    std::vector<std::vector<int>> below;
  };
  TileCholesky(int size, const Columns& columns);
  void find_subtrees(const std::vector<std::vector<int>>& below);
  [[nodiscard]] std::span<const Below> below(int column) const {
    return {below_.data() + below_begin_[column], below_.data() + below_begin_[column + 1]};
  }
  void fetch(const TileMatrix& matrix, int row, int column, std::size_t index);
  [[nodiscard]] int factor_column(const TileMatrix& matrix, int column, double least_pivot, const Run& run);
  [[nodiscard]] int factor_diagonal(int row, double least_pivot);
  void subtract_common(int row, std::size_t row_end, int column);
  void invert_column(int column, const Run& run);

  TileMatrix tiles_;
  int failed_row_ = -1;
  double work_ = 0;
  std::vector<std::size_t> below_begin_;  // of each tile column
  std::vector<Below> below_;
  std::vector<std::vector<int>> subtrees_;  // columns that need only one another, for threads
  std::vector<int> top_;                    // columns after them
  std::vector<double> diagonal_inverses_;   // of the factor's diagonal tiles
};

}  // namespace collinea::bundle
