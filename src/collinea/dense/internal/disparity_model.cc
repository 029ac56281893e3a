// SPDX-License-Identifier: Apache-2.0
#include "collinea/dense/internal/disparity_model.h"

#include <Eigen/LU>
#include <algorithm>
#include <utility>

namespace collinea {
namespace {

constexpr std::size_t kLeastInSquare = 4;  // that an interval is made of
constexpr double kGrowth = 1.5;            // of a square with fewer

}  // namespace

std::vector<Eigen::Vector2d> left_positions(std::span<const LevelPoint> points) {
  std::vector<Eigen::Vector2d> positions;
  for (const LevelPoint& point : points) positions.push_back(point.left_px);
  return positions;
}

DisparityModel::DisparityModel(std::span<const LevelPoint> points, std::vector<Eigen::Vector2d> positions,
                               Delaunay triangles)
    : points_(points.begin(), points.end()), triangles_(std::move(triangles)), squares_(std::move(positions)) {}

Result<DisparityModel> DisparityModel::of(std::span<const LevelPoint> points) {
  std::vector<Eigen::Vector2d> positions = left_positions(points);
  auto triangles = Delaunay::of(positions);
  if (!triangles)
    return fail(Errc::kIllPosed,
                "the points that are to guide the matching make no triangle: fewer than three, or on a line");
  return DisparityModel(points, std::move(positions), std::move(*triangles));
}

// The smallest and largest disparity in a square, which grows until it holds enough points.
DisparityInterval DisparityModel::interval(const Eigen::Vector2d& at, double half_px) const {
  for (;; half_px *= kGrowth) {
    std::size_t count = 0;
    DisparityInterval found{0, 0};
    squares_.in_square(at, half_px, [&](std::size_t i) {
      const double disparity = points_[i].disparity_px;
      found.low_px = count == 0 ? disparity : std::min(found.low_px, disparity);
      found.high_px = count == 0 ? disparity : std::max(found.high_px, disparity);
      ++count;
    });
    if (count >= std::min(kLeastInSquare, points_.size())) return found;
  }
}

std::optional<double> DisparityModel::at(const Eigen::Vector2d& position) const {
  const auto found = triangles_.find(position);
  if (!found) return std::nullopt;
  double disparity_px = 0;
  const auto& corners = triangles_.triangles()[std::size_t(found->triangle)].corners;
  for (std::size_t i = 0; i < 3; ++i) disparity_px += found->weights[i] * points_[std::size_t(corners[i])].disparity_px;
  return disparity_px;
}

std::optional<Eigen::Vector2d> DisparityModel::gradient_at(const Eigen::Vector2d& position) const {
  const auto found = triangles_.find(position);
  if (!found) return std::nullopt;
  const auto& corners = triangles_.triangles()[std::size_t(found->triangle)].corners;
  const LevelPoint& first = points_[std::size_t(corners[0])];
  Eigen::Matrix2d sides;
  Eigen::Vector2d rises;
  for (int i = 0; i < 2; ++i) {
    const LevelPoint& other = points_[std::size_t(corners[std::size_t(i) + 1])];
    sides.row(i) = (other.left_px - first.left_px).transpose();
    rises[i] = other.disparity_px - first.disparity_px;
  }
  const Eigen::Vector2d gradient = sides.inverse() * rises;
  if (!gradient.allFinite()) return std::nullopt;
  return gradient.cwiseMax(-kSteepest).cwiseMin(kSteepest);
}

const LevelPoint& DisparityModel::nearest(const Eigen::Vector2d& position) const {
  return points_[squares_.nearest(position, 1).front()];
}

DisparityInterval DisparityModel::around(const Eigen::Vector2d& at, double square_px) const {
  DisparityInterval searched = interval(at, square_px / 2);
  if (const auto predicted = this->at(at)) {
    searched.low_px = std::min(searched.low_px, *predicted);
    searched.high_px = std::max(searched.high_px, *predicted);
  }
  const double beyond = kSteepest * (nearest(at).left_px - at).norm();
  searched.low_px -= beyond;
  searched.high_px += beyond;
  return searched;
}

}  // namespace collinea
