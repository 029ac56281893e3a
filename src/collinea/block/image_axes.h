// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "collinea/block/block.h"

namespace collinea {

/// The right edge of an image as it is looked at, from its middle, in the camera as pixels are stored. `orientation`
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

/// The attitude of a camera as drones write it, in a world with x east, y north and z up. Roll turns the camera
/// clockwise about its axis, as seen from behind.
[[nodiscard]] inline Eigen::Quaterniond cam_from_world(const AttitudePrior& attitude) {
  constexpr double kRadians = std::numbers::pi / 180;
  const double heading = attitude.heading_deg * kRadians, pitch = attitude.pitch_deg * kRadians,
               roll = attitude.roll_deg * kRadians;
  const Eigen::Vector3d forward(std::sin(heading) * std::cos(pitch), std::cos(heading) * std::cos(pitch),
                                std::sin(pitch));
  const Eigen::Vector3d level(std::cos(heading), -std::sin(heading), 0), below = forward.cross(level);
  Eigen::Matrix3d rotation;
  rotation.row(0) = std::cos(roll) * level + std::sin(roll) * below;
  rotation.row(1) = -std::sin(roll) * level + std::cos(roll) * below;
  rotation.row(2) = forward;
  return Eigen::Quaterniond(rotation);
}

/// The inverse; straight down, where heading and roll are one, some pair of them.
[[nodiscard]] inline AttitudePrior attitude_prior(const Eigen::Quaterniond& cam_from_world) {
  constexpr double kDegrees = 180 / std::numbers::pi;
  const Eigen::Matrix3d rotation = cam_from_world.toRotationMatrix();
  const Eigen::Vector3d forward = rotation.row(2);
  const double heading = std::atan2(forward.x(), forward.y());
  const Eigen::Vector3d level(std::cos(heading), -std::sin(heading), 0), below = forward.cross(level);
  return {heading * kDegrees, std::atan2(forward.z(), forward.head<2>().norm()) * kDegrees,
          std::atan2(rotation.row(0).dot(below), rotation.row(0).dot(level)) * kDegrees};
}

}  // namespace collinea
