// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace collinea {

/// What lenses have in common that see a plane as a plane but for their distortion: an undistorted image of X/Z, Y/Z.
/// `Model::undistorted(params, measured)` is that image of measured coordinates, and does the rest.
template <class Model>
struct Central {
  static constexpr bool kIsFisheye = false;

  /// The functions of camera.h of that name, of measured coordinates (xd, yd).
  static Eigen::Vector2d normalized(const double* params, const Eigen::Vector2d& measured) {
    return Model::undistorted(params, measured);
  }
  static Eigen::Vector3d ray(const double* params, const Eigen::Vector2d& measured) {
    const Eigen::Vector2d direction = Model::undistorted(params, measured);
    return Eigen::Vector3d(direction.x(), direction.y(), 1).normalized();
  }
  static bool in_plane(const double*, const Eigen::Vector2d&) { return true; }
  static double pixels_per_unit(double focal_px, const Eigen::Vector2d&) { return focal_px; }
};

}  // namespace collinea
