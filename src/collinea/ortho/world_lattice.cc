// SPDX-License-Identifier: Apache-2.0
#include "collinea/ortho/world_lattice.h"

#include <algorithm>

namespace collinea {

WorldLattice::WorldLattice(const LocalFrame* frame, const MapGrid& grid, int column, int row, int width, int height,
                           double lowest_m, double highest_m)
    : same_(frame == nullptr),
      west_m_(grid.east_of(column)),
      north_m_(grid.north_of(row)),
      cell_m_(grid.cell_m),
      lowest_m_(lowest_m),
      height_range_m_(std::max(highest_m - lowest_m, 1.0)) {
  if (same_) return;
  spacing_ = std::clamp(int(50 / cell_m_), 1, 32);
  columns_ = width / spacing_ + 2, rows_ = height / spacing_ + 2;
  for (int j = 0; j < rows_; ++j) {
    for (int i = 0; i < columns_; ++i) {
      low_.push_back(map_at(i * spacing_, j * spacing_, lowest_m_));
      high_.push_back(map_at(i * spacing_, j * spacing_, lowest_m_ + height_range_m_));
    }
  }
  frame->local_from_map(low_);
  frame->local_from_map(high_);
}

Eigen::Vector3d WorldLattice::at(double x, double y, double height_m) const {
  if (same_) return map_at(x, y, height_m);
  const double u = x / spacing_, v = y / spacing_;
  const int i = std::clamp(int(u), 0, columns_ - 2), j = std::clamp(int(v), 0, rows_ - 2);
  const double a = u - i, b = v - j, t = (height_m - lowest_m_) / height_range_m_;
  const double w00 = (1 - a) * (1 - b), w10 = a * (1 - b), w01 = (1 - a) * b, w11 = a * b;
  const std::size_t node = std::size_t(j) * std::size_t(columns_) + std::size_t(i),
                    below = node + std::size_t(columns_);
  const Eigen::Vector3d low = w00 * low_[node] + w10 * low_[node + 1] + w01 * low_[below] + w11 * low_[below + 1];
  const Eigen::Vector3d high = w00 * high_[node] + w10 * high_[node + 1] + w01 * high_[below] + w11 * high_[below + 1];
  return low + t * (high - low);
}

}  // namespace collinea
