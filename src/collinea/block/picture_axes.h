// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>

namespace collinea {

/// The right edge of a picture as it is looked at, from its middle, in the camera as pixels are stored. `orientation`
/// is Image::orientation; left and right are not told apart.
inline Eigen::Vector3d right_in_cam(int orientation) {
  return orientation >= 5 ? Eigen::Vector3d::UnitY() : Eigen::Vector3d::UnitX();
}

/// Its lower edge.
inline Eigen::Vector3d down_in_cam(int orientation) {
  constexpr double kSigns[] = {1, 1, -1, -1, 1, 1, -1, -1};  // EXIF 1..8
  const double sign = kSigns[std::clamp(orientation, 1, 8) - 1];
  return sign * (orientation >= 5 ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitY());
}

}  // namespace collinea
