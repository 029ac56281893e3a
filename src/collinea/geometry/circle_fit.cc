// SPDX-License-Identifier: Apache-2.0
#include "collinea/geometry/circle_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>

namespace collinea {

std::optional<FittedCircle> algebraic_circle(std::span<const Eigen::Vector2d> points) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const Eigen::Vector2d& p : points) {
    const Eigen::Vector3d row(2 * p.x(), 2 * p.y(), 1);
    normal += row * row.transpose();
    right += row * p.squaredNorm();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(normal, Eigen::EigenvaluesOnly);
  const Eigen::Vector3d circle = normal.ldlt().solve(right);
  const double radius = std::sqrt(circle.z() + circle.head<2>().squaredNorm());
  if (!std::isfinite(radius)) return std::nullopt;
  return FittedCircle{circle.head<2>(), radius, eigen.eigenvalues()[0] / eigen.eigenvalues()[2]};
}

}  // namespace collinea
