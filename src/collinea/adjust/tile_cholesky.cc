// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/tile_cholesky.h"

#include <algorithm>
#include <array>
#include <cmath>
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

TileCholesky::TileCholesky(int size, std::vector<int> first_tile) : size_(size), first_(std::move(first_tile)) {
  COLLINEA_CHECK(static_cast<int>(first_.size()) == (size + kTile - 1) / kTile);
  row_begin_.resize(first_.size() + 1, 0);
  for (int i = 0; i < tile_rows(); ++i) {
    COLLINEA_CHECK(first_[i] >= 0 && first_[i] <= i);
    row_begin_[i + 1] = row_begin_[i] + static_cast<std::size_t>(i - first_[i] + 1);
  }
  tiles_.resize(row_begin_.back() * kTileSize);
  diagonal_inverses_.resize(first_.size() * kTileSize);
  clear();
}

void TileCholesky::clear() {
  std::fill(tiles_.begin(), tiles_.end(), 0.0);
  for (int i = size_; i < tile_rows() * kTile; ++i) at(i, i) = 1;
}

bool TileCholesky::factor_diagonal(int row, double least_pivot) {
  double* t = tile(row, row);
  for (int j = 0; j < kTile; ++j) {
    double* pivot_column = t + j * kTile;
    const double pivot = pivot_column[j];
    const double original = diagonal_inverses_[static_cast<std::size_t>(row) * kTileSize + j];
    if (!(pivot > least_pivot * original) || !std::isfinite(pivot)) {
      failed_row_ = row * kTile + j;
      return false;
    }
    const double root = std::sqrt(pivot), scale = 1 / root;
    pivot_column[j] = root;
    for (int i = j + 1; i < kTile; ++i) pivot_column[i] *= scale;
    for (int c = j + 1; c < kTile; ++c) {
      double* column = t + c * kTile;
      const double value = pivot_column[c];
      for (int i = c; i < kTile; ++i) column[i] -= value * pivot_column[i];
    }
  }
  return true;
}

bool TileCholesky::factor(const Run& run, double least_pivot) {
  constexpr int kRowsWorthThreads = 12;
  Run serial;
  for (int j = 0; j < tile_rows() && !run.stopped(); ++j) {
    double* diagonal = tile(j, j);
    double* inverse = diagonal_inverses_.data() + static_cast<std::size_t>(j) * kTileSize;
    for (int i = 0; i < kTile; ++i) inverse[i] = diagonal[i * kTile + i];  // kept for the test of the pivots
    subtract_product(diagonal, tile(j, first_[j]), tile(j, first_[j]), (j - first_[j]) * kTile);
    if (!factor_diagonal(j, least_pivot)) return false;
    invert_triangle(diagonal, inverse);

    const auto finish_tile = [&](std::size_t below) {
      const int i = j + 1 + static_cast<int>(below);
      if (first_[i] > j) return;
      const int from = std::max(first_[i], first_[j]);
      if (from < j) subtract_product(tile(i, j), tile(i, from), tile(j, from), (j - from) * kTile);
      multiply_by_transposed(tile(i, j), inverse);
    };
    const int below = tile_rows() - 1 - j;
    parallel_for(below >= kRowsWorthThreads && j - first_[j] >= kRowsWorthThreads / 2 ? run : serial,
                 static_cast<std::size_t>(below), finish_tile);
  }
  failed_row_ = -1;
  return true;
}

void TileCholesky::solve(double* x) const {
  std::array<double, kTile> part;
  for (int i = 0; i < tile_rows(); ++i) {
    double* xi = x + i * kTile;
    const double* columns = tile(i, first_[i]);
    for (int k = first_[i] * kTile; k < i * kTile; ++k, columns += kTile)
      for (int r = 0; r < kTile; ++r) xi[r] -= columns[r] * x[k];
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
    const double* columns = tile(i, first_[i]);
    for (int k = first_[i] * kTile; k < i * kTile; ++k, columns += kTile) {
      double sum = 0;
      for (int r = 0; r < kTile; ++r) sum += columns[r] * xi[r];
      x[k] -= sum;
    }
  }
}

// From the last column to the first: with M(j) = L(j,k) L(k,k)^-1, the inverse Z has
//     Z(i,k) = -sum over j > k of Z(i,j) M(j)  and  Z(k,k) = L(k,k)^-T L(k,k)^-1 - sum over j > k of M(j)^T Z(j,k).
// The rows that hold column k hold every tile Z(i,j) that is asked for.
void TileCholesky::invert() {
  std::vector<int> rows;
  std::vector<double> transposed_m, above;
  std::array<double, kTileSize> inverse_t, z_t, m_t, sum;
  for (int k = tile_rows() - 1; k >= 0; --k) {
    rows.clear();
    for (int i = k + 1; i < tile_rows(); ++i)
      if (first_[i] <= k) rows.push_back(i);
    const double* inverse = diagonal_inverses_.data() + static_cast<std::size_t>(k) * kTileSize;
    transpose(inverse, inverse_t.data());
    transposed_m.assign(rows.size() * kTileSize, 0.0);
    for (std::size_t a = 0; a < rows.size(); ++a) {  // M^T by columns = M by rows
      std::array<double, kTileSize> m;
      std::copy_n(tile(rows[a], k), kTileSize, m.data());
      multiply_by_transposed(m.data(), inverse_t.data());
      transpose(m.data(), transposed_m.data() + a * kTileSize);
    }
    above.assign(rows.size() * kTileSize, 0.0);  // Z(i,k)
    for (std::size_t a = 0; a < rows.size(); ++a)
      for (std::size_t b = 0; b < rows.size(); ++b) {
        const int i = std::max(rows[a], rows[b]), j = std::min(rows[a], rows[b]);
        const double* z = tile(i, j);
        if (rows[a] < rows[b]) {
          transpose(z, z_t.data());
          z = z_t.data();
        }
        subtract_product(above.data() + a * kTileSize, z, transposed_m.data() + b * kTileSize, kTile);
      }
    sum.fill(0);
    std::array<double, kTileSize> negative;
    for (int n = 0; n < kTileSize; ++n) negative[n] = -inverse_t[n];
    subtract_product(sum.data(), negative.data(), inverse_t.data(), kTile);
    for (std::size_t a = 0; a < rows.size(); ++a) {
      transpose(above.data() + a * kTileSize, m_t.data());
      subtract_product(sum.data(), transposed_m.data() + a * kTileSize, m_t.data(), kTile);
    }
    for (int c = 0; c < kTile; ++c)  // the whole tile, symmetric to the last bit
      for (int r = 0; r < kTile; ++r) tile(k, k)[c * kTile + r] = r >= c ? sum[c * kTile + r] : sum[r * kTile + c];
    for (std::size_t a = 0; a < rows.size(); ++a)
      std::copy_n(above.data() + a * kTileSize, kTileSize, tile(rows[a], k));
  }
}

}  // namespace collinea::bundle
