// SPDX-License-Identifier: Apache-2.0
#include "collinea/geometry/plane_squares.h"

#include <utility>

namespace collinea {
namespace {

constexpr double kPointsInSquare = 4;
constexpr double kGrowth = 1.5;  // of what is looked through

}  // namespace

PlaneSquares::PlaneSquares(std::vector<Eigen::Vector2d> points) : points_(std::move(points)) {
  Eigen::Vector2d high = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < points_.size(); ++i) {
    corner_ = i == 0 ? points_[i] : Eigen::Vector2d(corner_.cwiseMin(points_[i]));
    high = i == 0 ? points_[i] : Eigen::Vector2d(high.cwiseMax(points_[i]));
  }
  const Eigen::Vector2d extent = high - corner_;
  const double squares = std::max(double(points_.size()) / kPointsInSquare, 1.0);
  // Of a long, narrow strip no more squares than of a broad one.
  side_ = std::max(std::sqrt(extent.x() * extent.y() / squares), extent.maxCoeff() / squares);
  if (!(side_ > 0)) side_ = 1;
  across_ = int(extent.x() / side_) + 1;
  down_ = int(extent.y() / side_) + 1;
  begin_.assign(std::size_t(across_) * std::size_t(down_) + 1, 0);
  std::vector<std::size_t> square;
  for (const Eigen::Vector2d& point : points_) {
    const Eigen::Vector2d at = (point - corner_) / side_;
    square.push_back(std::size_t(at.y()) * std::size_t(across_) + std::size_t(at.x()));
    ++begin_[square.back() + 1];
  }
  for (std::size_t s = 1; s < begin_.size(); ++s) begin_[s] += begin_[s - 1];
  order_.resize(points_.size());
  std::vector<std::size_t> next(begin_.begin(), begin_.end() - 1);
  for (std::size_t i = 0; i < points_.size(); ++i) order_[next[square[i]]++] = i;
}

std::vector<std::size_t> PlaneSquares::nearest(const Eigen::Vector2d& at, std::size_t count) const {
  count = std::min(count, points_.size());
  std::vector<std::size_t> indices;
  if (count == 0) return indices;
  const Eigen::Vector2d high = corner_ + side_ * Eigen::Vector2d(across_, down_);
  const double outside = (at - at.cwiseMax(corner_).cwiseMin(high)).norm();
  std::vector<std::pair<double, std::size_t>> found;
  // All points within `half` lie in the square: the nearest are known once so many lie in its circle.
  for (double half = outside + side_;; half *= kGrowth) {
    found.clear();
    in_square(at, half, [&](std::size_t i) { found.emplace_back((points_[i] - at).squaredNorm(), i); });
    if (found.size() < count) continue;
    const auto last = found.begin() + std::ptrdiff_t(count);
    std::nth_element(found.begin(), last - 1, found.end());
    if (found[count - 1].first <= half * half || found.size() == points_.size()) break;
  }
  std::sort(found.begin(), found.begin() + std::ptrdiff_t(count));
  for (std::size_t k = 0; k < count; ++k) indices.push_back(found[k].second);
  return indices;
}

}  // namespace collinea
