// SPDX-License-Identifier: Apache-2.0
#include "collinea/geometry/plane_squares.h"

#include <utility>

namespace collinea {
namespace {

constexpr double kPointsInSquare = 4;
constexpr double kRounding = 1e-9;  // by which a point may lie outside its square

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

std::vector<std::size_t> PlaneSquares::nearest(const Eigen::Vector2d& at, std::size_t count, double within) const {
  count = std::min(count, points_.size());
  if (count == 0) return {};
  const Eigen::Vector2d inside =
      at.cwiseMax(corner_).cwiseMin(corner_ + side_ * Eigen::Vector2d(across_, down_));  // nearest of the squares
  const int column = std::min(int((inside.x() - corner_.x()) / side_), across_ - 1);
  const int row = std::min(int((inside.y() - corner_.y()) / side_), down_ - 1);
  const double outside2 = (at - inside).squaredNorm();
  std::vector<std::pair<double, std::size_t>> found;  // the nearest so far, a heap with the farthest on top
  const auto look = [&](int x, int y) {
    const std::size_t s = std::size_t(y) * std::size_t(across_) + std::size_t(x);
    for (std::size_t i = begin_[s]; i < begin_[s + 1]; ++i) {
      const std::pair point((points_[order_[i]] - at).squaredNorm(), order_[i]);
      if (point.first > within * within || (found.size() == count && point > found.front())) continue;
      if (found.size() == count) {
        std::pop_heap(found.begin(), found.end());
        found.pop_back();
      }
      found.push_back(point);
      std::push_heap(found.begin(), found.end());
    }
  };
  // Ring by ring of squares round that of the position.
  for (int ring = 0; ring <= std::max(across_, down_); ++ring) {
    const double reach = std::max(ring - 1, 0) * side_ * (1 - kRounding), least2 = reach * reach + outside2;
    if (least2 > within * within || (found.size() == count && least2 > found.front().first)) break;
    for (int y = std::max(row - ring, 0); y <= std::min(row + ring, down_ - 1); ++y) {
      const bool is_whole = std::abs(y - row) == ring;  // a row of the ring, not its ends alone
      for (int x = column - ring; x <= column + ring; x += is_whole || ring == 0 ? 1 : 2 * ring)
        if (x >= 0 && x < across_) look(x, y);
    }
  }
  std::sort_heap(found.begin(), found.end());
  std::vector<std::size_t> indices;
  for (const auto& [distance2, index] : found) indices.push_back(index);
  return indices;
}

}  // namespace collinea
