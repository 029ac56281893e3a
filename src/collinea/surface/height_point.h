// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

namespace collinea {

/// A point of a surface.
struct HeightPoint {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< east, north, height [m]
  double sigma_m = 0;                                  ///< of its height; 0: not known
};

/// East and north alone.
[[nodiscard]] inline std::vector<Eigen::Vector2d> in_plan(std::span<const HeightPoint> points) {
  std::vector<Eigen::Vector2d> positions;
  for (const HeightPoint& point : points) positions.emplace_back(point.position.head<2>());
  return positions;
}

}  // namespace collinea
