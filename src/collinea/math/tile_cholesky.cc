// SPDX-License-Identifier: Apache-2.0
#include "collinea/math/tile_cholesky.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "collinea/base/parallel.h"
#include "collinea/base/result.h"

namespace collinea::bundle {
namespace {

// l := inverse of the lower triangular tile; zeros above the diagonal.
void invert_triangle(const double* factor, double* inverse) {
  std::fill(inverse, inverse + kTileSize, 0.0);
  for (int column = 0; column < kTile; ++column) {
    double* x = inverse + column * kTile;
    x[column] = 1;
    for (int k = column; k < kTile; ++k) {
      const double* l = factor + k * kTile;
      const double value = x[k] /= l[k];
      for (int row = k + 1; row < kTile; ++row) x[row] -= value * l[row];
    }
  }
}

void transpose(const double* tile, double* transposed) {
  for (int c = 0; c < kTile; ++c)
    for (int r = 0; r < kTile; ++r) transposed[r * kTile + c] = tile[c * kTile + r];
}

// tile := tile * right^T
void multiply_by_transposed(double* tile, const double* right) {
  std::array<double, kTileSize> left;
  for (int i = 0; i < kTileSize; ++i) {
    left[i] = -tile[i];
    tile[i] = 0;
  }
  subtract_product(tile, left.data(), right, kTile);
}

TilePattern rows_of(const std::vector<std::vector<int>>& below) {
  TilePattern rows(below.size());
  for (std::size_t k = 0; k < below.size(); ++k)
    for (const int row : below[k]) rows[static_cast<std::size_t>(row)].push_back(static_cast<int>(k));
  return rows;
}

}  // namespace

// Those of the matrix; and of each column its rows but the first also in the column of that first one (its parent in
// the elimination tree).
std::vector<std::vector<int>> factor_columns(const TilePattern& pattern) {
  const int rows = static_cast<int>(pattern.size());
  std::vector<std::vector<int>> below(pattern.size());
  for (int i = 0; i < rows; ++i)
    for (const int column : pattern[i]) {
      COLLINEA_CHECK(column >= 0 && column <= i);
      if (column < i) below[column].push_back(i);
    }
  for (auto& column : below) {
    std::sort(column.begin(), column.end());
    column.erase(std::unique(column.begin(), column.end()), column.end());
    if (column.empty()) continue;
    auto& parent = below[column.front()];
    parent.insert(parent.end(), column.begin() + 1, column.end());
  }
  return below;
}

TileCholesky::TileCholesky(int size, const TilePattern& pattern)
    : TileCholesky(size, Columns{factor_columns(pattern)}) {}

TileCholesky::TileCholesky(int size, const Columns& columns) : tiles_(size, rows_of(columns.below)) {
  const auto& below = columns.below;
  below_begin_.push_back(0);
  std::vector<std::size_t> next;
  for (int row = 0; row < tiles_.tile_rows(); ++row) next.push_back(tiles_.first(row));
  for (std::size_t k = 0; k < below.size(); ++k) {  // ascending, as the columns of every row
    const double products = static_cast<double>(below[k].size());
    work_ += (products + 1) * (products + 2) / 2;
    for (const int row : below[k]) below_.push_back({row, next[static_cast<std::size_t>(row)]++});
    below_begin_.push_back(below_.size());
  }
  diagonal_inverses_.resize(below.size() * kTileSize);
  find_subtrees(below);
}

// Cuts the elimination tree into subtrees of at most a sixteenth of the work each, and what is above them.
void TileCholesky::find_subtrees(const std::vector<std::vector<int>>& below) {
  constexpr double kShare = 1.0 / 16;
  const std::size_t rows = below.size();
  std::vector<double> work(rows);
  double total = 0;
  for (std::size_t k = 0; k < rows; ++k) {
    const double tiles = 1.0 + static_cast<double>(below[k].size());
    total += tiles * tiles;
    work[k] += tiles * tiles;  // with its descendants, which come before it
    if (!below[k].empty()) work[static_cast<std::size_t>(below[k].front())] += work[k];
  }
  std::vector<int> subtree(rows, -1);
  for (std::size_t k = rows; k-- > 0;) {
    if (work[k] > kShare * total) continue;
    const int parent = below[k].empty() ? -1 : subtree[static_cast<std::size_t>(below[k].front())];
    subtree[k] = parent;
    if (parent >= 0) continue;
    subtree[k] = static_cast<int>(subtrees_.size());
    subtrees_.emplace_back();
  }
  for (std::size_t k = 0; k < rows; ++k)
    (subtree[k] >= 0 ? subtrees_[static_cast<std::size_t>(subtree[k])] : top_).push_back(static_cast<int>(k));
}

// The first row whose pivot is too small; -1 when there is none.
int TileCholesky::factor_diagonal(int row, double least_pivot) {
  double* t = tiles_.tile(tiles_.diagonal(row));
  for (int j = 0; j < kTile; ++j) {
    double* pivot_column = t + j * kTile;
    const double pivot = pivot_column[j];
    const double original = diagonal_inverses_[static_cast<std::size_t>(row) * kTileSize + j];
    if (!(pivot > least_pivot * original) || !std::isfinite(pivot)) return row * kTile + j;
    const double root = std::sqrt(pivot), scale = 1 / root;
    pivot_column[j] = root;
    for (int i = j + 1; i < kTile; ++i) pivot_column[i] *= scale;
    for (int c = j + 1; c < kTile; ++c) {
      double* column = t + c * kTile;
      const double value = pivot_column[c];
      for (int i = c; i < kTile; ++i) column[i] -= value * pivot_column[i];
    }
  }
  return -1;
}

// Tile at row_end of `row`, in `column`, minus the products of what both rows hold before it. Stretches where both have
// the same columns side by side go to the kernel at once.
void TileCholesky::subtract_common(int row, std::size_t row_end, int column) {
  std::size_t a = tiles_.first(row), b = tiles_.first(column);
  const std::size_t b_end = tiles_.diagonal(column);
  const auto same = [&](std::size_t k) { return tiles_.column_of(a + k) == tiles_.column_of(b + k); };
  while (a < row_end && b < b_end) {
    if (!same(0)) {
      ++(tiles_.column_of(a) < tiles_.column_of(b) ? a : b);
      continue;
    }
    std::size_t count = 1;
    while (a + count < row_end && b + count < b_end && same(count)) ++count;
    subtract_product(tiles_.tile(row_end), tiles_.tile(a), tiles_.tile(b), static_cast<int>(count) * kTile);
    a += count;
    b += count;
  }
}

// A tile of the matrix to its position in the factor, or zeros.
void TileCholesky::fetch(const TileMatrix& matrix, int row, int column, std::size_t index) {
  const std::size_t given = matrix.find(row, column);
  if (given == TileMatrix::kNowhere)
    std::fill_n(tiles_.tile(index), kTileSize, 0.0);
  else
    std::copy_n(matrix.tile(given), kTileSize, tiles_.tile(index));
}

int TileCholesky::factor_column(const TileMatrix& matrix, int j, double least_pivot, const Run& run) {
  constexpr std::size_t kTilesWorthThreads = 1600;  // products
  const std::size_t first = tiles_.first(j), on_diagonal = tiles_.diagonal(j);
  double *inverse = diagonal_inverses_.data() + static_cast<std::size_t>(j) * kTileSize,
         *pivots = tiles_.tile(on_diagonal);
  fetch(matrix, j, j, on_diagonal);
  for (int i = 0; i < kTile; ++i) inverse[i] = pivots[i * kTile + i];  // kept for the test of the pivots
  subtract_product(pivots, tiles_.tile(first), tiles_.tile(first), static_cast<int>(on_diagonal - first) * kTile);
  if (const int failed = factor_diagonal(j, least_pivot); failed >= 0) return failed;
  invert_triangle(pivots, inverse);
  Run serial;
  const std::span<const Below> rows = below(j);
  parallel_for(rows.size() * (on_diagonal - first) > kTilesWorthThreads ? run : serial, rows.size(),
               [&](std::size_t i) {
                 fetch(matrix, rows[i].row, j, rows[i].index);
                 subtract_common(rows[i].row, rows[i].index, j);
                 multiply_by_transposed(tiles_.tile(rows[i].index), inverse);
               });
  return -1;
}

bool TileCholesky::factor(const TileMatrix& matrix, const Run& run, double least_pivot) {
  COLLINEA_CHECK(matrix.tile_rows() == tile_rows());
  std::vector<int> failed(subtrees_.size(), -1);
  Run serial;
  serial.stop = run.stop;
  parallel_for(run, subtrees_.size(), [&](std::size_t s) {
    for (const int j : subtrees_[s]) {
      if (run.stopped()) return;
      if ((failed[s] = factor_column(matrix, j, least_pivot, serial)) >= 0) return;
    }
  });
  failed_row_ = -1;
  for (const int row : failed)
    if (row >= 0 && (failed_row_ < 0 || row < failed_row_)) failed_row_ = row;
  for (std::size_t i = 0; i < top_.size() && failed_row_ < 0 && !run.stopped(); ++i)
    failed_row_ = factor_column(matrix, top_[i], least_pivot, run);
  return failed_row_ < 0 && !run.stopped();
}

void TileCholesky::solve(double* x) const {
  std::array<double, kTile> part;
  for (int i = 0; i < tile_rows(); ++i) {
    double* xi = x + i * kTile;
    for (std::size_t t = tiles_.first(i); t < tiles_.diagonal(i); ++t)
      subtract_times(xi, tiles_.tile(t), x + tiles_.column_of(t) * kTile);
    part.fill(0);
    subtract_times(part.data(), diagonal_inverses_.data() + static_cast<std::size_t>(i) * kTileSize, xi);
    for (int r = 0; r < kTile; ++r) xi[r] = -part[r];
  }
  for (int i = tile_rows() - 1; i >= 0; --i) {
    double* xi = x + i * kTile;
    part.fill(0);
    subtract_transposed_times(part.data(), diagonal_inverses_.data() + static_cast<std::size_t>(i) * kTileSize, xi);
    for (int r = 0; r < kTile; ++r) xi[r] = -part[r];
    for (std::size_t t = tiles_.first(i); t < tiles_.diagonal(i); ++t)
      subtract_transposed_times(x + tiles_.column_of(t) * kTile, tiles_.tile(t), xi);
  }
}

// From the last column to the first: with M(j) = L(j,k) L(k,k)^-1, the inverse Z has
//     Z(i,k) = -sum over j > k of Z(i,j) M(j)  and  Z(k,k) = L(k,k)^-T L(k,k)^-1 - sum over j > k of M(j)^T Z(j,k).
// The rows that hold column k hold every tile Z(i,j) that is asked for; of those with i < j the transposed is held, and
// their share of Z(i,k) is summed up transposed.
void TileCholesky::invert_column(int k, const Run& run) {
  constexpr std::size_t kRowsWorthThreads = 8;
  const std::span<const Below> rows = below(k);
  const std::size_t count = rows.size();
  const double* inverse = diagonal_inverses_.data() + static_cast<std::size_t>(k) * kTileSize;
  std::array<double, kTileSize> inverse_t, sum;
  transpose(inverse, inverse_t.data());
  std::vector<double> transposed_m(count * kTileSize), above(count * kTileSize, 0.0);
  std::vector<std::size_t> indices(count * count);  // of Z(i,j), by rows
  for (std::size_t a = 0; a < count; ++a) {         // M^T by columns = M by rows
    multiply_by_transposed(tiles_.tile(rows[a].index), inverse_t.data());
    transpose(tiles_.tile(rows[a].index), transposed_m.data() + a * kTileSize);
    std::size_t index = rows[a].index;
    for (std::size_t b = 0; b < a; ++b) {
      while (tiles_.column_of(index) != rows[b].row) ++index;
      indices[a * count + b] = index;
    }
    indices[a * count + a] = tiles_.diagonal(rows[a].row);
  }
  Run serial;
  parallel_for(count >= kRowsWorthThreads ? run : serial, count, [&](std::size_t a) {  // Z(i,k)
    double* its = above.data() + a * kTileSize;
    const std::size_t* index = indices.data() + a * count;
    std::array<double, kTileSize> transposed{};
    for (std::size_t b = a + 1; b < count; ++b)
      subtract_plain_product(transposed.data(), transposed_m.data() + b * kTileSize,
                             tiles_.tile(indices[b * count + a]));
    transpose(transposed.data(), its);
    for (std::size_t b = 0, end = 0; b <= a; b = end) {
      for (end = b + 1; end <= a && index[end] == index[end - 1] + 1;) ++end;
      subtract_product(its, tiles_.tile(index[b]), transposed_m.data() + b * kTileSize,
                       static_cast<int>(end - b) * kTile);
    }
  });
  sum.fill(0);
  subtract_product(sum.data(), inverse_t.data(), inverse_t.data(), kTile);
  for (double& value : sum) value = -value;
  for (std::size_t a = 0; a < count; ++a)
    subtract_plain_product(sum.data(), transposed_m.data() + a * kTileSize, above.data() + a * kTileSize);
  double* on_diagonal = tiles_.tile(tiles_.diagonal(k));
  for (int c = 0; c < kTile; ++c)  // the whole tile, symmetric to the last bit
    for (int r = 0; r < kTile; ++r) on_diagonal[c * kTile + r] = r >= c ? sum[c * kTile + r] : sum[r * kTile + c];
  for (std::size_t a = 0; a < count; ++a)
    std::copy_n(above.data() + a * kTileSize, kTileSize, tiles_.tile(rows[a].index));
}

void TileCholesky::invert(const Run& run) {
  for (int k = tile_rows() - 1; k >= 0 && !run.stopped(); --k) invert_column(k, run);
}

}  // namespace collinea::bundle
