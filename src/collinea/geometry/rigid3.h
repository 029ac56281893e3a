// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace collinea {

/// A rigid motion between two frames, named after both: `Rigid3 b_from_a`.
///     point_in_b = b_from_a * point_in_a = R * point_in_a + t
struct Rigid3 {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();  ///< unit norm
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();         ///< origin of a, seen in b [m]
};

inline Eigen::Vector3d operator*(const Rigid3& b_from_a, const Eigen::Vector3d& point_in_a) {
  return b_from_a.rotation * point_in_a + b_from_a.translation;
}

inline Rigid3 operator*(const Rigid3& c_from_b, const Rigid3& b_from_a) {
  return {(c_from_b.rotation * b_from_a.rotation).normalized(), c_from_b * b_from_a.translation};
}

inline Rigid3 inverse(const Rigid3& b_from_a) {
  const Eigen::Quaterniond a_from_b = b_from_a.rotation.conjugate();
  return {a_from_b, -(a_from_b * b_from_a.translation)};
}

/// Where the origin of `cam` lies in `world`: the projection centre of a camera.
inline Eigen::Vector3d centre_of(const Rigid3& cam_from_world) {
  return -(cam_from_world.rotation.conjugate() * cam_from_world.translation);
}

}  // namespace collinea
