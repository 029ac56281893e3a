// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <span>

namespace collinea {

inline constexpr double kNearLine = 0.1;  ///< width over length below which points lie near a line

/// Width over length of points, as standard deviations along their second and first axis; 0 of one point.
[[nodiscard]] inline double width_over_length(std::span<const Eigen::Vector3d> points) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& point : points) mean += point / double(points.size());
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& point : points) spread += (point - mean) * (point - mean).transpose();
  const Eigen::Vector3d axes =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread, Eigen::EigenvaluesOnly).eigenvalues();
  return axes[2] > 0 ? std::sqrt(std::max(0.0, axes[1]) / axes[2]) : 0;
}

}  // namespace collinea
