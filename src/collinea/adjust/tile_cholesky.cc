// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/tile_cholesky.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

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

TileCholesky::TileCholesky(int size, const TilePattern& pattern) : size_(size) {
  COLLINEA_CHECK(static_cast<int>(pattern.size()) == (size + kTile - 1) / kTile);
  lay_out(pattern);
  tiles_.resize(columns_.size() * kTileSize);
  diagonal_inverses_.resize(pattern.size() * kTileSize);
  clear();
}

void TileCholesky::lay_out(const TilePattern& pattern) {
  const std::vector<std::vector<int>> below = factor_columns(pattern);
  const std::size_t rows = pattern.size();
  row_begin_.assign(rows + 1, 0);
  below_begin_.assign(rows + 1, 0);
  for (std::size_t k = 0; k < rows; ++k) {
    below_begin_[k + 1] = below_begin_[k] + below[k].size();
    ++row_begin_[k + 1];
    for (const int row : below[k]) ++row_begin_[static_cast<std::size_t>(row) + 1];
  }
  std::partial_sum(row_begin_.begin(), row_begin_.end(), row_begin_.begin());
  columns_.resize(row_begin_.back());
  std::vector<std::size_t> next(row_begin_.begin(), row_begin_.end() - 1);
  for (std::size_t k = 0; k < rows; ++k) {  // ascending: so are the columns of every row, and the diagonal is the last
    columns_[next[k]++] = static_cast<int>(k);
    for (const int row : below[k]) {
      below_.push_back({row, next[static_cast<std::size_t>(row)]});
      columns_[next[static_cast<std::size_t>(row)]++] = static_cast<int>(k);
    }
  }
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

std::size_t TileCholesky::find(int row, int column) const {
  const std::size_t begin = row_begin_[row], end = row_begin_[row + 1];
  if (column == row) return end - 1;
  const std::size_t guess = begin + static_cast<std::size_t>(column);  // of a full row
  if (guess < end && columns_[guess] == column) return guess;
  const auto found = std::lower_bound(columns_.begin() + static_cast<std::ptrdiff_t>(begin),
                                      columns_.begin() + static_cast<std::ptrdiff_t>(end), column);
  const auto at = static_cast<std::size_t>(found - columns_.begin());
  return at < end && columns_[at] == column ? at : kNowhere;
}

std::size_t TileCholesky::place(int row, int column) const {
  const std::size_t found = find(row, column);
  COLLINEA_CHECK(found != kNowhere);
  return found;
}

void TileCholesky::clear() {
  std::fill(tiles_.begin(), tiles_.end(), 0.0);
  for (int i = size_; i < tile_rows() * kTile; ++i) at(i, i) = 1;
}

// The first row whose pivot is too small; -1 when there is none.
int TileCholesky::factor_diagonal(int row, double least_pivot) {
  double* t = tile(diagonal(row));
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
  std::size_t a = row_begin_[row], b = row_begin_[column];
  const std::size_t b_end = diagonal(column);
  while (a < row_end && b < b_end) {
    if (columns_[a] != columns_[b]) {
      ++(columns_[a] < columns_[b] ? a : b);
      continue;
    }
    std::size_t count = 1;
    while (a + count < row_end && b + count < b_end && columns_[a + count] == columns_[b + count]) ++count;
    subtract_product(tile(row_end), tile(a), tile(b), static_cast<int>(count) * kTile);
    a += count;
    b += count;
  }
}

int TileCholesky::factor_column(int j, double least_pivot, const Run& run) {
  constexpr std::size_t kTilesWorthThreads = 1600;  // products
  const std::size_t first = row_begin_[j], on_diagonal = diagonal(j);
  double* inverse = diagonal_inverses_.data() + static_cast<std::size_t>(j) * kTileSize;
  for (int i = 0; i < kTile; ++i) inverse[i] = tile(on_diagonal)[i * kTile + i];  // kept for the test of the pivots
  subtract_product(tile(on_diagonal), tile(first), tile(first), static_cast<int>(on_diagonal - first) * kTile);
  if (const int failed = factor_diagonal(j, least_pivot); failed >= 0) return failed;
  invert_triangle(tile(on_diagonal), inverse);
  Run serial;
  const std::span<const Below> rows = below(j);
  parallel_for(rows.size() * (on_diagonal - first) > kTilesWorthThreads ? run : serial, rows.size(),
               [&](std::size_t i) {
                 subtract_common(rows[i].row, rows[i].place, j);
                 multiply_by_transposed(tile(rows[i].place), inverse);
               });
  return -1;
}

bool TileCholesky::factor(const Run& run, double least_pivot) {
  std::vector<int> failed(subtrees_.size(), -1);
  Run serial;
  serial.stop = run.stop;
  parallel_for(run, subtrees_.size(), [&](std::size_t s) {
    for (const int j : subtrees_[s]) {
      if (run.stopped()) return;
      if ((failed[s] = factor_column(j, least_pivot, serial)) >= 0) return;
    }
  });
  failed_row_ = -1;
  for (const int row : failed)
    if (row >= 0 && (failed_row_ < 0 || row < failed_row_)) failed_row_ = row;
  for (std::size_t i = 0; i < top_.size() && failed_row_ < 0 && !run.stopped(); ++i)
    failed_row_ = factor_column(top_[i], least_pivot, run);
  return failed_row_ < 0;
}

void TileCholesky::solve(double* x) const {
  std::array<double, kTile> part;
  for (int i = 0; i < tile_rows(); ++i) {
    double* xi = x + i * kTile;
    for (std::size_t t = row_begin_[i]; t < diagonal(i); ++t) {
      const double* values = tile(t);
      const double* xk = x + columns_[t] * kTile;
      for (int c = 0; c < kTile; ++c, values += kTile)
        for (int r = 0; r < kTile; ++r) xi[r] -= values[r] * xk[c];
    }
    const double* inverse = diagonal_inverses_.data() + static_cast<std::size_t>(i) * kTileSize;
    part.fill(0);
    for (int c = 0; c < kTile; ++c)
      for (int r = c; r < kTile; ++r) part[r] += inverse[c * kTile + r] * xi[c];
    std::copy(part.begin(), part.end(), xi);
  }
  for (int i = tile_rows() - 1; i >= 0; --i) {
    double* xi = x + i * kTile;
    const double* inverse = diagonal_inverses_.data() + static_cast<std::size_t>(i) * kTileSize;
    for (int c = 0; c < kTile; ++c) {
      double sum = 0;
      for (int r = c; r < kTile; ++r) sum += inverse[c * kTile + r] * xi[r];
      part[c] = sum;
    }
    std::copy(part.begin(), part.end(), xi);
    for (std::size_t t = row_begin_[i]; t < diagonal(i); ++t) {
      const double* values = tile(t);
      double* xk = x + columns_[t] * kTile;
      for (int c = 0; c < kTile; ++c, values += kTile) {
        double sum = 0;
        for (int r = 0; r < kTile; ++r) sum += values[r] * xi[r];
        xk[c] -= sum;
      }
    }
  }
}

// From the last column to the first: with M(j) = L(j,k) L(k,k)^-1, the inverse Z has
//     Z(i,k) = -sum over j > k of Z(i,j) M(j)  and  Z(k,k) = L(k,k)^-T L(k,k)^-1 - sum over j > k of M(j)^T Z(j,k).
// The rows that hold column k hold every tile Z(i,j) that is asked for.
void TileCholesky::invert_column(int k, const Run& run) {
  constexpr std::size_t kRowsWorthThreads = 8;
  const std::span<const Below> rows = below(k);
  const double* inverse = diagonal_inverses_.data() + static_cast<std::size_t>(k) * kTileSize;
  std::array<double, kTileSize> inverse_t, m_t, sum, negative;
  transpose(inverse, inverse_t.data());
  std::vector<double> transposed_m(rows.size() * kTileSize), above(rows.size() * kTileSize, 0.0);
  for (std::size_t a = 0; a < rows.size(); ++a) {  // M^T by columns = M by rows
    multiply_by_transposed(tile(rows[a].place), inverse_t.data());
    transpose(tile(rows[a].place), transposed_m.data() + a * kTileSize);
  }
  Run serial;
  parallel_for(rows.size() >= kRowsWorthThreads ? run : serial, rows.size(), [&](std::size_t a) {  // Z(i,k)
    std::array<double, kTileSize> z_t;
    for (std::size_t b = 0; b < rows.size(); ++b) {
      const double* z = tile(place(std::max(rows[a].row, rows[b].row), std::min(rows[a].row, rows[b].row)));
      if (a < b) {
        transpose(z, z_t.data());
        z = z_t.data();
      }
      subtract_product(above.data() + a * kTileSize, z, transposed_m.data() + b * kTileSize, kTile);
    }
  });
  sum.fill(0);
  for (int n = 0; n < kTileSize; ++n) negative[n] = -inverse_t[n];
  subtract_product(sum.data(), negative.data(), inverse_t.data(), kTile);
  for (std::size_t a = 0; a < rows.size(); ++a) {
    transpose(above.data() + a * kTileSize, m_t.data());
    subtract_product(sum.data(), transposed_m.data() + a * kTileSize, m_t.data(), kTile);
  }
  double* on_diagonal = tile(diagonal(k));
  for (int c = 0; c < kTile; ++c)  // the whole tile, symmetric to the last bit
    for (int r = 0; r < kTile; ++r) on_diagonal[c * kTile + r] = r >= c ? sum[c * kTile + r] : sum[r * kTile + c];
  for (std::size_t a = 0; a < rows.size(); ++a)
    std::copy_n(above.data() + a * kTileSize, kTileSize, tile(rows[a].place));
}

void TileCholesky::invert(const Run& run) {
  for (int k = tile_rows() - 1; k >= 0 && !run.stopped(); --k) invert_column(k, run);
}

}  // namespace collinea::bundle
