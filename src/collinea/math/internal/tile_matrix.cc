// SPDX-License-Identifier: Apache-2.0
#include "collinea/math/internal/tile_matrix.h"

#include <algorithm>

#include "collinea/base/result.h"

namespace collinea::bundle {

TileMatrix::TileMatrix(int size, const TilePattern& pattern) : size_(size) {
  COLLINEA_CHECK(static_cast<int>(pattern.size()) == (size + kTile - 1) / kTile);
  row_begin_.push_back(0);
  for (int row = 0; row < static_cast<int>(pattern.size()); ++row) {
    const auto begin = static_cast<std::ptrdiff_t>(columns_.size());
    columns_.insert(columns_.end(), pattern[row].begin(), pattern[row].end());
    columns_.push_back(row);
    std::sort(columns_.begin() + begin, columns_.end());
    columns_.erase(std::unique(columns_.begin() + begin, columns_.end()), columns_.end());
    COLLINEA_CHECK(columns_[begin] >= 0 && columns_.back() == row);
    row_begin_.push_back(columns_.size());
  }
  tiles_.resize(columns_.size() * kTileSize);
  clear();
}

std::size_t TileMatrix::find(int row, int column) const {
  const std::size_t begin = row_begin_[row], end = row_begin_[row + 1];
  if (column == row) return end - 1;
  const std::size_t guess = begin + static_cast<std::size_t>(column);  // of a full row
  if (guess < end && columns_[guess] == column) return guess;
  const auto found = std::lower_bound(columns_.begin() + static_cast<std::ptrdiff_t>(begin),
                                      columns_.begin() + static_cast<std::ptrdiff_t>(end), column);
  const auto at = static_cast<std::size_t>(found - columns_.begin());
  return at < end && columns_[at] == column ? at : kNowhere;
}

double& TileMatrix::at(int row, int column) {
  const std::size_t index = find(row / kTile, column / kTile);
  COLLINEA_CHECK(index != kNowhere);
  return tile(index)[column % kTile * kTile + row % kTile];
}

void TileMatrix::clear() {
  std::fill(tiles_.begin(), tiles_.end(), 0.0);
  for (int i = size_; i < tile_rows() * kTile; ++i) at(i, i) = 1;
}

void TileMatrix::times(const double* x, double* y) const {
  const std::ptrdiff_t rows = static_cast<std::ptrdiff_t>(tile_rows()) * kTile;
  std::fill(y, y + rows, 0.0);
  for (int row = 0; row < tile_rows(); ++row) {  // the negative of it
    const double* its_x = x + row * kTile;
    double* its_y = y + row * kTile;
    for (std::size_t index = first(row); index < diagonal(row); ++index) {
      const int column = column_of(index);
      subtract_times(its_y, tile(index), x + column * kTile);
      subtract_transposed_times(y + column * kTile, tile(index), its_x);
    }
    const double* values = tile(diagonal(row));  // of which the lower triangle counts
    for (int c = 0; c < kTile; ++c, values += kTile) {
      double sum = values[c] * its_x[c];
      for (int r = c + 1; r < kTile; ++r) {
        its_y[r] -= values[r] * its_x[c];
        sum += values[r] * its_x[r];
      }
      its_y[c] -= sum;
    }
  }
  for (std::ptrdiff_t i = 0; i < rows; ++i) y[i] = -y[i];
}

}  // namespace collinea::bundle
