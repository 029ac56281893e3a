// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "collinea/geometry/rotation_angles.h"

namespace collinea {

/// A photograph as the collinearity equations of the textbooks have it (Mussio 1.3): x right, y up, image plane at
/// z = -c, principal point at 0.
struct CollinearityPhoto {
  double principal_distance = 1;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  CardanAngles angles;
};

/// Where a point is seen, x = -c Nx / D, y = -c Ny / D with (Nx, Ny, D) = R (X - X0), and the derivatives (Mussio
/// 1.3.3, errata E6-E8).
struct CollinearityAt {
  Eigen::Vector2d xy = Eigen::Vector2d::Zero();
  double denominator = 0;                                      ///< D: negative before the camera
  Eigen::Matrix<double, 2, 3> by_centre, by_point, by_angles;  ///< angles: omega, phi, kappa
};
[[nodiscard]] CollinearityAt collinearity(const CollinearityPhoto& photo, const Eigen::Vector3d& point);

}  // namespace collinea
