// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "collinea/geometry/similarity3.h"

namespace collinea {

// Absolute orientation in closed form, without approximate values, all points of equal weight; beside align()
// (Umeyama). With exact points all three agree; with errors align() and align_by_quaternion() have the same rotation,
// the least-squares one, and all differ in the scale.

/// The rotation from the largest eigenvalue of a symmetric 4 x 4 matrix (Sanso 1973, Horn 1987); the scale by the ratio
/// of the spreads on both sides, the same both ways round. Nothing with fewer than three points or points on a line.
[[nodiscard]] std::optional<Similarity3> align_by_quaternion(std::span<const Eigen::Vector3d> points_in_a,
                                                             std::span<const Eigen::Vector3d> points_in_b);

/// What the linear solution finds: b = scale R' a + t in Mussio's notation (4.1).
struct RodriguesFit {
  Similarity3 b_from_a;
  Eigen::Vector3d abc = Eigen::Vector3d::Zero();  ///< R' = (I - S)^-1 (I + S), S = [0 c -b; -c 0 a; b -a 0]
  bool was_turned_first = false;                  ///< by half a turn about an axis, because the rotation is near pi
};

/// The rotation from linear equations in Rodrigues' parameters (Mussio 4.1.3, with sums where the text prints
/// differences, erratum E38), the scale by the ratio of the spreads. Not quite least squares: errors of the points
/// stand in the matrix. A rotation near pi, where the parameters grow without bound, is turned first. Nothing as above.
[[nodiscard]] std::optional<RodriguesFit> align_by_rodrigues(std::span<const Eigen::Vector3d> points_in_a,
                                                             std::span<const Eigen::Vector3d> points_in_b);

}  // namespace collinea
