// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

namespace collinea {

/// Where the side from a to b of a polygon crosses the line of that y: the x. Of two sides that meet on the line one
/// crosses it or both or none do, so that what is inside lies behind an odd number of crossings.
[[nodiscard]] inline std::optional<double> crossing(const Eigen::Vector2d& a, const Eigen::Vector2d& b, double y) {
  if ((a.y() > y) == (b.y() > y)) return std::nullopt;
  return a.x() + (y - a.y()) / (b.y() - a.y()) * (b.x() - a.x());
}

}  // namespace collinea
