// SPDX-License-Identifier: Apache-2.0
#include "collinea/dense/internal/disparity_model.h"

#include <algorithm>
#include <cmath>

namespace collinea {
namespace {

constexpr double kPointsInSquare = 4;
constexpr std::size_t kLeastInSquare = 4;  // that an interval is made of

}  // namespace

DisparityNeighbours::DisparityNeighbours(std::span<const LevelPoint> points) : points_(points.begin(), points.end()) {
  Eigen::Vector2d high = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < points_.size(); ++i) {
    corner_ = i == 0 ? points_[i].left_px : Eigen::Vector2d(corner_.cwiseMin(points_[i].left_px));
    high = i == 0 ? points_[i].left_px : Eigen::Vector2d(high.cwiseMax(points_[i].left_px));
  }
  const Eigen::Vector2d extent = high - corner_;
  extent_px_ = std::max(extent.maxCoeff(), 1.0);
  const double squares = std::max(double(points_.size()) / kPointsInSquare, 1.0);
  side_px_ = std::max({std::sqrt(extent.x() * extent.y() / squares), extent_px_ / squares, 1.0});
  across_ = int(extent.x() / side_px_) + 1;
  down_ = int(extent.y() / side_px_) + 1;
  begin_.assign(std::size_t(across_) * std::size_t(down_) + 1, 0);
  std::vector<std::size_t> square;
  for (const LevelPoint& point : points_) {
    const Eigen::Vector2d at = (point.left_px - corner_) / side_px_;
    square.push_back(std::size_t(at.y()) * std::size_t(across_) + std::size_t(at.x()));
    ++begin_[square.back() + 1];
  }
  for (std::size_t s = 1; s < begin_.size(); ++s) begin_[s] += begin_[s - 1];
  order_.resize(points_.size());
  std::vector<std::size_t> next(begin_.begin(), begin_.end() - 1);
  for (std::size_t i = 0; i < points_.size(); ++i) order_[next[square[i]]++] = i;
}

template <class Visit>
void DisparityNeighbours::in_square(const Eigen::Vector2d& at, double half_px, const Visit& visit) const {
  const auto limited = [&](double value, int count) { return int(std::clamp(std::floor(value), 0.0, count - 1.0)); };
  const Eigen::Vector2d low = (at - corner_) / side_px_ - Eigen::Vector2d::Constant(half_px / side_px_);
  const Eigen::Vector2d high = (at - corner_) / side_px_ + Eigen::Vector2d::Constant(half_px / side_px_);
  for (int y = limited(low.y(), down_); y <= limited(high.y(), down_); ++y)
    for (int x = limited(low.x(), across_); x <= limited(high.x(), across_); ++x) {
      const std::size_t s = std::size_t(y) * std::size_t(across_) + std::size_t(x);
      for (std::size_t i = begin_[s]; i < begin_[s + 1]; ++i)
        if ((points_[order_[i]].left_px - at).cwiseAbs().maxCoeff() <= half_px) visit(order_[i]);
    }
}

std::vector<double> DisparityNeighbours::disparities(std::size_t i, std::size_t count) const {
  std::vector<std::pair<double, std::size_t>> found;
  const Eigen::Vector2d at = points_[i].left_px;
  // All points within half_px are in the square: the nearest ones are known when so many lie in its circle.
  for (double half_px = side_px_; half_px < 4 * extent_px_; half_px *= 2) {
    found.clear();
    in_square(at, half_px, [&](std::size_t j) { found.emplace_back((points_[j].left_px - at).squaredNorm(), j); });
    std::sort(found.begin(), found.end());
    if (found.size() >= count && found[count - 1].first <= half_px * half_px) break;
  }
  std::vector<double> values;
  for (std::size_t k = 0; k < std::min(count, found.size()); ++k)
    values.push_back(points_[found[k].second].disparity_px);
  return values;
}

DisparityInterval DisparityNeighbours::interval(const Eigen::Vector2d& at, double half_px, std::size_t least) const {
  for (;; half_px *= 1.5) {
    std::size_t count = 0;
    DisparityInterval found{0, 0};
    in_square(at, half_px, [&](std::size_t j) {
      const double disparity = points_[j].disparity_px;
      found.low_px = count == 0 ? disparity : std::min(found.low_px, disparity);
      found.high_px = count == 0 ? disparity : std::max(found.high_px, disparity);
      ++count;
    });
    if (count >= std::min(least, points_.size())) return found;
  }
}

DisparityModel::DisparityModel(std::span<const LevelPoint> points, Delaunay triangles)
    : points_(points.begin(), points.end()), triangles_(std::move(triangles)), neighbours_(points) {}

Result<DisparityModel> DisparityModel::of(std::span<const LevelPoint> points) {
  std::vector<Eigen::Vector2d> positions;
  for (const LevelPoint& point : points) positions.push_back(point.left_px);
  auto triangles = Delaunay::of(positions);
  if (!triangles)
    return fail(Errc::kIllPosed,
                "the points that are to guide the matching make no triangle: fewer than three, or on a line");
  return DisparityModel(points, std::move(*triangles));
}

DisparityInterval DisparityModel::around(const Eigen::Vector2d& at, double square_px) const {
  DisparityInterval interval = neighbours_.interval(at, square_px / 2, kLeastInSquare);
  if (const auto found = triangles_.find(at)) {
    double predicted = 0;
    const auto& corners = triangles_.triangles()[std::size_t(found->triangle)].corners;
    for (std::size_t i = 0; i < 3; ++i) predicted += found->weights[i] * points_[std::size_t(corners[i])].disparity_px;
    interval.low_px = std::min(interval.low_px, predicted);
    interval.high_px = std::max(interval.high_px, predicted);
  }
  return interval;
}

}  // namespace collinea
