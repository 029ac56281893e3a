// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>

#include "collinea/geometry/rigid3.h"

namespace collinea {

/// A motion with change of scale: point_in_b = scale * R * point_in_a + t.
struct Similarity3 {
  double scale = 1;
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();  ///< unit norm
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();         ///< origin of a, seen in b
};

inline Eigen::Vector3d operator*(const Similarity3& b_from_a, const Eigen::Vector3d& point_in_a) {
  return b_from_a.scale * (b_from_a.rotation * point_in_a) + b_from_a.translation;
}

inline Similarity3 inverse(const Similarity3& b_from_a) {
  const Eigen::Quaterniond a_from_b = b_from_a.rotation.conjugate();
  return {1 / b_from_a.scale, a_from_b, -(a_from_b * b_from_a.translation) / b_from_a.scale};
}

/// The pose of a camera after its world frame has been changed by `b_from_a`; the camera frame keeps the scale of b.
inline Rigid3 moved(const Rigid3& cam_from_a, const Similarity3& b_from_a) {
  const Eigen::Quaterniond cam_from_b = (cam_from_a.rotation * b_from_a.rotation.conjugate()).normalized();
  const Eigen::Vector3d centre_in_b = b_from_a * centre_of(cam_from_a);
  return {cam_from_b, -(cam_from_b * centre_in_b)};
}

/// The least-squares similarity between corresponding points, each pair with its weight (empty: all 1); Umeyama (1991).
/// Nothing with fewer than three pairs or when the points lie on one line.
[[nodiscard]] std::optional<Similarity3> align(std::span<const Eigen::Vector3d> points_in_a,
                                               std::span<const Eigen::Vector3d> points_in_b,
                                               std::span<const double> weights = {});

}  // namespace collinea
