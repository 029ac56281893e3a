// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace collinea {

/// How the atmosphere bends the rays of an image: what lies in one direction shows in another, farther from the nadir.
struct RayBend {
  Eigen::Vector3d down_in_cam{0, 0, 1};  ///< unit vector to the nadir
  double per_tangent_rad = 0;            ///< over the tangent of the angle from the nadir; 0: rays are straight

  /// The direction, of the same scale, in which the image shows what lies along the straight `ray`: to first order
  /// turned by per_tangent_rad tan(angle). Beyond 75 degrees from the nadir, where layers are no longer flat, as it is.
  [[nodiscard]] Eigen::Vector3d bent(const Eigen::Vector3d& ray) const {
    constexpr double kSquaredTangent = 13.928;  // of 75 degrees
    if (per_tangent_rad == 0) return ray;
    const double down = ray.dot(down_in_cam);
    const Eigen::Vector3d across = ray - down * down_in_cam;
    const double squared = across.squaredNorm();
    if (!(down > 0) || !(squared < kSquaredTangent * down * down)) return ray;
    return ray + per_tangent_rad * (across - squared / down * down_in_cam);
  }
};

}  // namespace collinea
