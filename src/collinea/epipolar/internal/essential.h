// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <span>

#include "collinea/epipolar/internal/point_pairs.h"
#include "collinea/geometry/rigid3.h"
#include "collinea/math/few.h"

namespace collinea {

/// The essential matrices E with (x2, y2, 1) E (x1, y1, 1)' = 0 for five pairs of undistorted image coordinates (X/Z,
/// Y/Z); E = [t]x R of second_from_first, each of Frobenius norm sqrt(2). Null space by Householder, elimination and
/// 10th-degree polynomial after Nister (PAMI 2004), roots by Sturm chain. None when the five pairs do not give five
/// independent equations (repeated pairs, points on one line in both images).
[[nodiscard]] Few<Eigen::Matrix3d, 10> five_point(const std::array<Eigen::Vector2d, 5>& first,
                                                  const std::array<Eigen::Vector2d, 5>& second);

/// E = [t]x R.
[[nodiscard]] Eigen::Matrix3d essential_matrix(const Rigid3& second_from_first);

/// The four motions (translation of unit length) an essential matrix stands for: {R, t}, {R, -t}, {R', t}, {R', -t}. A
/// matrix that is only nearly essential is first replaced by the nearest one.
[[nodiscard]] std::array<Rigid3, 4> motions(const Eigen::Matrix3d& essential);

/// Distances of a point along the two (x, y, 1) rays, from the cross products of the rays and the base; both are
/// positive when it lies in front of both cameras. The angle is that between the rays.
struct RayMeeting {
  double depth_first, depth_second;  ///< in units of the base; of either sign, infinite for parallel rays
  double angle_rad;
};
[[nodiscard]] RayMeeting meeting(const Rigid3& second_from_first, const Eigen::Vector2d& first,
                                 const Eigen::Vector2d& second);

/// The motion among `candidates` that puts most of the pairs `support` in front of both cameras; pairs whose rays are
/// parallel within min_angle_rad have no say. Nothing when no candidate has more than half of those that have.
[[nodiscard]] std::optional<Rigid3> in_front(std::span<const Rigid3> candidates, const PointPairs& pairs,
                                             std::span<const int> support, double min_angle_rad);

}  // namespace collinea
