// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <span>

#include "collinea/epipolar/internal/point_pairs.h"
#include "collinea/math/few.h"

namespace collinea {

/// The matrices F of rank 2 with (x2, y2, 1) F (x1, y1, 1)' = 0 for seven pairs, each of Frobenius norm 1 (Hartley and
/// Zisserman 2004, 11.1.2). The coordinates should be of size 1: undistorted image coordinates are. None when the pairs
/// do not give seven independent equations.
[[nodiscard]] Few<Eigen::Matrix3d, 3> seven_point(const std::array<Eigen::Vector2d, 7>& first,
                                                  const std::array<Eigen::Vector2d, 7>& second);

/// The matrix F of rank 2 and norm 1 from eight or more pairs `support` by linear least squares in normalised
/// coordinates (Hartley, PAMI 1997). Biased by noise: a start for refine_fundamental. Nothing with fewer than eight
/// pairs or when they do not determine it (points on one line, one plane, or one centre).
[[nodiscard]] std::optional<Eigen::Matrix3d> eight_point(const PointPairs& pairs, std::span<const int> support);

}  // namespace collinea
