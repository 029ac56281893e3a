// SPDX-License-Identifier: Apache-2.0
#include "collinea/geometry/rotation_derivatives.h"

#include <numbers>

#include "collinea/geometry/rotation.h"

namespace collinea {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Matrix3d turn_by(const CardanAngles& angles) {
  const Matrix3d by_kappa = rotation_matrix(CardanAngles{0, 0, angles.kappa_rad}),
                 by_both = rotation_matrix(CardanAngles{0, angles.phi_rad, angles.kappa_rad});
  Matrix3d turn;
  turn << -by_both.col(0), -by_kappa.col(1), -Vector3d::UnitZ();
  return turn;
}

Matrix3d turn_by(const EulerAngles& angles) {
  const Matrix3d by_spin = rotation_matrix(EulerAngles{0, 0, angles.spin_rad}),
                 by_both = rotation_matrix(EulerAngles{0, angles.nutation_rad, angles.spin_rad});
  Matrix3d turn;
  turn << -by_both.col(2), -by_spin.col(0), -Vector3d::UnitZ();
  return turn;
}

Matrix3d turn_by(const TopographicAngles& angles) {
  constexpr double kPi = std::numbers::pi;
  const Matrix3d turn = turn_by(EulerAngles{2 * kPi - angles.azimuth_rad, kPi - angles.zenith_rad, angles.roll_rad});
  return turn * Vector3d(-1, -1, 1).asDiagonal();
}

Matrix3d turn_by(const GeodeticAngles& angles) {
  constexpr double kRight = std::numbers::pi / 2;
  const Matrix3d euler =
      turn_by(EulerAngles{kRight + angles.longitude_rad, kRight - angles.latitude_rad, kRight - angles.azimuth_rad});
  Matrix3d turn;
  turn << -euler.col(1), euler.col(0), -euler.col(2);
  return turn;
}

Matrix3d turn_by(const RodriguesParameters& parameters) {
  const Vector3d half = Vector3d(parameters.a, parameters.b, parameters.c) / 2;
  return (Matrix3d::Identity() + skew(half)) / (1 + half.squaredNorm());
}

Eigen::Matrix<double, 3, 4> turn_by(const Eigen::Quaterniond& quaternion) {
  Eigen::Matrix<double, 3, 4> turn;  // 2 vec(dq q*) / q^2
  turn << -quaternion.vec(), quaternion.w() * Matrix3d::Identity() + skew(quaternion.vec());
  return 2 / quaternion.squaredNorm() * turn;
}

Eigen::Matrix<double, 3, 9> turn_by(const Matrix3d& rotation) {
  Eigen::Matrix<double, 3, 9> turn;
  for (int k = 0; k < 9; ++k) {
    Matrix3d change = Matrix3d::Zero();
    change(k / 3, k % 3) = 1;
    const Matrix3d by = (change * rotation.transpose() - rotation * change.transpose()) / 2;
    turn.col(k) = Vector3d(by(2, 1), by(0, 2), by(1, 0));
  }
  return turn;
}

Eigen::Matrix<double, 4, 3> by_rotation(const Eigen::Quaterniond& quaternion) {
  Eigen::Matrix<double, 4, 3> by;  // (0, w) q / 2
  by << -quaternion.vec().transpose(), quaternion.w() * Matrix3d::Identity() - skew(quaternion.vec());
  return by / 2;
}

Eigen::Matrix<double, 9, 3> by_rotation(const Matrix3d& rotation) {
  Eigen::Matrix<double, 9, 3> by;
  for (int axis = 0; axis < 3; ++axis) {
    const Matrix3d change = skew(Vector3d::Unit(axis)) * rotation;
    for (int k = 0; k < 9; ++k) by(k, axis) = change(k / 3, k % 3);
  }
  return by;
}

}  // namespace collinea
