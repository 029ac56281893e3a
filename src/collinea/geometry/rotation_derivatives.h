// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "collinea/geometry/rotation_angles.h"

namespace collinea {

// What a change of its parameters does to a rotation R = image_from_object: the rotation vector w (rad, about the axes
// of the image) of  dR = [w]x R. Columns in the order of the parameters. The way back from a form to another,
// d(parameters) = inverse(turn_by(other)) turn_by(one) d(one), carries covariances; at a singular attitude the matrix
// has no inverse. Angles of Cardan and Euler by  dRx(a) = -[e_x]x Rx da  of each elementary rotation.

[[nodiscard]] Eigen::Matrix3d turn_by(const CardanAngles& angles);
[[nodiscard]] Eigen::Matrix3d turn_by(const EulerAngles& angles);
[[nodiscard]] Eigen::Matrix3d turn_by(const TopographicAngles& angles);
[[nodiscard]] Eigen::Matrix3d turn_by(const GeodeticAngles& angles);
/// (I + [g]x) / (1 + g^2), g = (a, b, c) / 2 (Shuster 1993).
[[nodiscard]] Eigen::Matrix3d turn_by(const RodriguesParameters& parameters);
/// By w, x, y, z of a quaternion of any length; a change of its length turns nothing.
[[nodiscard]] Eigen::Matrix<double, 3, 4> turn_by(const Eigen::Quaterniond& quaternion);
/// By the nine elements, row by row, of a matrix near the rotation: that of the nearest rotation to it.
[[nodiscard]] Eigen::Matrix<double, 3, 9> turn_by(const Eigen::Matrix3d& rotation);

/// Back: the change of a unit quaternion (w, x, y, z), and of the nine elements row by row.
[[nodiscard]] Eigen::Matrix<double, 4, 3> by_rotation(const Eigen::Quaterniond& quaternion);
[[nodiscard]] Eigen::Matrix<double, 9, 3> by_rotation(const Eigen::Matrix3d& rotation);

}  // namespace collinea
