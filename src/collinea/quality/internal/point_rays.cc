// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/internal/point_rays.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "collinea/adjust/kind_image_point.h"

namespace collinea {
namespace {

constexpr double kLeastRedundancy = 0.05;  // below it errors of the model would be multiplied by more than four
constexpr double kSingular = 1e-10;        // of the largest pivot

}  // namespace

CheckedError checked_error(const Eigen::Vector2d& residual, const Eigen::Matrix2d& redundancy, double weight) {
  // Eigenvalues and eigenvectors of a symmetric matrix of two rows.
  const double a = redundancy(0, 0), b = 0.5 * (redundancy(0, 1) + redundancy(1, 0)), d = redundancy(1, 1);
  const double middle = (a + d) / 2, half = std::hypot((a - d) / 2, b), angle = 0.5 * std::atan2(2 * b, a - d);
  const Eigen::Vector2d first(std::cos(angle), std::sin(angle)), second(-first.y(), first.x());
  CheckedError error;
  const auto add = [&](const Eigen::Vector2d& direction, double lambda) {
    if (lambda < kLeastRedundancy) return;
    const double along = direction.dot(residual);
    // Prediction v / lambda with the variance 1 + (1 - lambda) / (weight lambda).
    error.squared += along * along * weight / (lambda * (weight * lambda + 1 - lambda));
    ++error.directions;
  };
  add(first, std::min(middle + half, 1.0));
  add(second, std::min(middle - half, 1.0));
  return error;
}

PointRays::PointRays(const bundle::Problem& problem, const bundle::State& state, std::size_t point)
    : is_fixed_(problem.point(point).is_fixed) {
  for (std::uint32_t r = problem.point(point).first_ray; r < problem.end_ray(point); ++r) {
    const bundle::Ray& ray = problem.rays[r];
    bundle::LinearRay linear;
    linearise(problem, state, ray, &state.points[3 * point], Loss{}, &linear);
    if (linear.root_weight == 0) continue;
    rays_.push_back({ray.source, Eigen::Vector2d(linear.residual[0], linear.residual[1]),
                     Eigen::Map<const Eigen::Matrix<double, 2, 3, Eigen::RowMajor>>(linear.by_point)});
  }
}

std::vector<CheckedError> PointRays::errors() const {
  std::vector<CheckedError> errors;
  if (is_fixed_) {
    for (const Measured& ray : rays_) errors.push_back(checked_error(ray.residual, Eigen::Matrix2d::Identity()));
    return errors;
  }
  if (rays_.size() < 2) return errors;
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const Measured& ray : rays_) {
    normal += ray.by_point.transpose() * ray.by_point;
    right += ray.by_point.transpose() * ray.residual;
  }
  const Eigen::LDLT<Eigen::Matrix3d> factor(normal);
  const Eigen::Vector3d pivots = factor.vectorD();
  if (!(pivots.minCoeff() > kSingular * pivots.maxCoeff())) return errors;
  const Eigen::Vector3d moved = factor.solve(right);
  for (const Measured& ray : rays_) {
    const Eigen::Matrix2d redundancy =
        Eigen::Matrix2d::Identity() - ray.by_point * factor.solve(ray.by_point.transpose());
    errors.push_back(checked_error(ray.residual - ray.by_point * moved, redundancy));
  }
  return errors;
}

}  // namespace collinea
