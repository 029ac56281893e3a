// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace collinea {

/// Where the side from a to b of a polygon crosses the line of that y: the x. Of two sides that meet on the line one
/// crosses it or both or none do, so that what is inside lies behind an odd number of crossings.
[[nodiscard]] inline std::optional<double> crossing(const Eigen::Vector2d& a, const Eigen::Vector2d& b, double y) {
  if ((a.y() > y) == (b.y() > y)) return std::nullopt;
  return a.x() + (y - a.y()) / (b.y() - a.y()) * (b.x() - a.x());
}

/// Whether a position lies inside a ring, closed by itself: behind an odd number of sides.
[[nodiscard]] inline bool is_inside(std::span<const Eigen::Vector2d> ring, const Eigen::Vector2d& position) {
  bool inside = false;
  for (std::size_t i = 0; i < ring.size(); ++i)
    if (const auto x = crossing(ring[i], ring[i + 1 < ring.size() ? i + 1 : 0], position.y()); x && *x <= position.x())
      inside = !inside;
  return inside;
}

/// A ring with its bounds: most positions are seen to lie outside at once.
class BoundedRing {
 public:
  explicit BoundedRing(std::vector<Eigen::Vector2d> points) : points_(std::move(points)) {
    for (const Eigen::Vector2d& point : points_) {
      lowest_ = lowest_.cwiseMin(point);
      highest_ = highest_.cwiseMax(point);
    }
  }
  [[nodiscard]] const std::vector<Eigen::Vector2d>& points() const { return points_; }
  [[nodiscard]] bool contains(const Eigen::Vector2d& position) const {
    return (position.array() >= lowest_.array()).all() && (position.array() <= highest_.array()).all() &&
           is_inside(points_, position);
  }

 private:
  std::vector<Eigen::Vector2d> points_;
  Eigen::Vector2d lowest_ = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity()), highest_ = -lowest_;
};

}  // namespace collinea
