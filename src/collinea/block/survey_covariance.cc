// SPDX-License-Identifier: Apache-2.0
#include "collinea/block/survey_covariance.h"

#include <Eigen/Eigenvalues>
#include <cmath>

namespace collinea {
namespace {

constexpr double kLeastEigenvalue = 1e-6;  // of the correlation matrix: an axis that is a thousandth of another

Eigen::Matrix3d correlation_matrix(const Eigen::Vector3d& sigma_m, const Eigen::Vector3d& correlation) {
  Eigen::Matrix3d matrix;
  matrix << 1, correlation[0], correlation[1],  //
      correlation[0], 1, correlation[2],        //
      correlation[1], correlation[2], 1;
  for (int axis = 0; axis < 3; ++axis)
    if (!(sigma_m[axis] > 0 && std::isfinite(sigma_m[axis]))) {
      matrix.row(axis).setZero();
      matrix.col(axis).setZero();
      matrix(axis, axis) = 1;
    }
  return matrix;
}

Eigen::Vector3d finite(const Eigen::Vector3d& sigma_m) { return sigma_m.array().isFinite().select(sigma_m, 0.0); }

}  // namespace

Eigen::Matrix3d survey_covariance(const Eigen::Vector3d& sigma_m, const Eigen::Vector3d& correlation) {
  const Eigen::Vector3d sigma = finite(sigma_m);
  return sigma.asDiagonal() * correlation_matrix(sigma_m, correlation) * sigma.asDiagonal();
}

std::optional<Eigen::Matrix3d> survey_weight(const Eigen::Vector3d& sigma_m, const Eigen::Vector3d& correlation) {
  const Eigen::Matrix3d matrix = correlation_matrix(sigma_m, correlation);
  if (!matrix.allFinite()) return std::nullopt;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(matrix);
  if (eigen.eigenvalues()[0] < kLeastEigenvalue) return std::nullopt;
  const Eigen::Vector3d sigma = finite(sigma_m);
  const Eigen::Vector3d inverse_sigma = (sigma.array() > 0).select(sigma.cwiseInverse(), 0.0);
  const Eigen::Matrix3d inverse =
      eigen.eigenvectors() * eigen.eigenvalues().cwiseInverse().asDiagonal() * eigen.eigenvectors().transpose();
  return inverse_sigma.asDiagonal() * inverse * inverse_sigma.asDiagonal();
}

Eigen::Vector3d correlation_of(const Eigen::Matrix3d& covariance_m2) {
  const auto of = [&](int a, int b) {
    const double both = covariance_m2(a, a) * covariance_m2(b, b);
    return covariance_m2(a, a) > 0 && both > 0 ? covariance_m2(a, b) / std::sqrt(both) : 0.0;
  };
  return {of(0, 1), of(0, 2), of(1, 2)};
}

}  // namespace collinea
