// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "collinea/epipolar/intersect.h"

namespace collinea {

/// A sight line whose exterior orientation has a covariance of its own.
struct UncertainSightLine {
  SightLine line;
  /// Of [rotation about the axes of the world (rad), centre (m)]; zero: exact.
  Eigen::Matrix<double, 6, 6> pose_covariance = Eigen::Matrix<double, 6, 6>::Zero();
};

/// One ray against the others.
struct RayTest {
  Eigen::Vector2d misfit = Eigen::Vector2d::Zero();      ///< measured minus computed [px]
  Eigen::Vector2d redundancy = Eigen::Vector2d::Zero();  ///< local; of all: 2 N - 3
  Eigen::Vector2d w = Eigen::Vector2d::Zero();           ///< Baarda's test by the stated sigmas
};

struct OrientedIntersection {
  Eigen::Vector3d point_in_world = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< [m^2], of image coordinates and orientations
  int redundancy = 0;
  double sigma0 = 1;
  double max_angle_rad = 0;  ///< between two rays, at the point
  std::vector<RayTest> rays;
};

/// Intersection of n rays by least squares with  W = sigma^2 I + J C_pose J'  for each ray: errors of orientations
/// count as what they are in the image; those of different images are taken as independent. 2 N - 3 are redundant.
/// Nothing as intersect(), or when a covariance is not positive semi-definite.
[[nodiscard]] std::optional<OrientedIntersection> intersect_oriented(std::span<const UncertainSightLine> lines);

}  // namespace collinea
