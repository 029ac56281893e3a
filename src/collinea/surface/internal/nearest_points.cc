// SPDX-License-Identifier: Apache-2.0
#include "collinea/surface/internal/nearest_points.h"

#include <algorithm>
#include <cmath>

namespace collinea {
namespace {

constexpr double kPointsInSquare = 4;

}  // namespace

NearestPoints::NearestPoints(std::span<const HeightPoint> points) : points_(points.begin(), points.end()) {
  Eigen::Vector2d high = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const Eigen::Vector2d at = points_[i].position.head<2>();
    corner_ = i == 0 ? at : Eigen::Vector2d(corner_.cwiseMin(at));
    high = i == 0 ? at : Eigen::Vector2d(high.cwiseMax(at));
  }
  const Eigen::Vector2d extent = high - corner_;
  const double squares = std::max(double(points_.size()) / kPointsInSquare, 1.0);
  // Of a long, narrow strip no more squares than of a broad one.
  side_m_ = std::max(std::sqrt(extent.x() * extent.y() / squares), extent.maxCoeff() / squares);
  if (!(side_m_ > 0)) side_m_ = 1;
  across_ = int(extent.x() / side_m_) + 1;
  down_ = int(extent.y() / side_m_) + 1;
  begin_.assign(std::size_t(across_) * std::size_t(down_) + 1, 0);
  std::vector<std::size_t> square(points_.size());
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const auto [x, y] = square_of(points_[i].position.head<2>());
    square[i] = std::size_t(y) * std::size_t(across_) + std::size_t(x);
    ++begin_[square[i] + 1];
  }
  for (std::size_t s = 1; s < begin_.size(); ++s) begin_[s] += begin_[s - 1];
  order_.resize(points_.size());
  std::vector<std::size_t> next(begin_.begin(), begin_.end() - 1);
  for (std::size_t i = 0; i < points_.size(); ++i) order_[next[square[i]]++] = i;
}

std::pair<int, int> NearestPoints::square_of(const Eigen::Vector2d& on_map) const {
  const Eigen::Vector2d at = (on_map - corner_) / side_m_;
  const auto limited = [](double value, int count) { return int(std::clamp(std::floor(value), 0.0, count - 1.0)); };
  return {limited(at.x(), across_), limited(at.y(), down_)};
}

std::vector<std::size_t> NearestPoints::around(const Eigen::Vector2d& on_map, std::size_t count) const {
  const auto [x, y] = square_of(on_map);
  std::vector<std::pair<double, std::size_t>> found;
  const auto take = [&](int column, int row) {
    if (column < 0 || row < 0 || column >= across_ || row >= down_) return;
    const std::size_t s = std::size_t(row) * std::size_t(across_) + std::size_t(column);
    for (std::size_t i = begin_[s]; i < begin_[s + 1]; ++i)
      found.emplace_back((points_[order_[i]].position.head<2>() - on_map).squaredNorm(), order_[i]);
  };
  // How far a position outside all squares is from the nearest one.
  const Eigen::Vector2d low = corner_, high = corner_ + side_m_ * Eigen::Vector2d(across_, down_);
  const double outside_m = (on_map - on_map.cwiseMax(low).cwiseMin(high)).norm();
  for (int ring = 0; ring <= std::max(across_, down_); ++ring) {
    for (int k = -ring; k <= ring; ++k) {
      take(x + k, y - ring);
      if (ring > 0) take(x + k, y + ring);
    }
    for (int k = 1 - ring; k < ring; ++k) {
      take(x - ring, y + k);
      take(x + ring, y + k);
    }
    // Points of farther rings are at least so far away.
    const double seen_m = std::max(ring * side_m_, 0.0);
    if (found.size() < count || outside_m > 0) continue;
    std::nth_element(found.begin(), found.begin() + std::ptrdiff_t(count - 1), found.end());
    if (found[count - 1].first <= seen_m * seen_m) break;
  }
  std::sort(found.begin(), found.end());
  if (found.size() > count) found.resize(count);
  std::vector<std::size_t> nearest;
  for (const auto& [distance, index] : found) nearest.push_back(index);
  return nearest;
}

}  // namespace collinea
