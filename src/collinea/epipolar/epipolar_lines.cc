// SPDX-License-Identifier: Apache-2.0
#include "collinea/epipolar/epipolar_lines.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "collinea/geometry/rotation.h"

namespace collinea {
namespace {

// Pixels by X/Z, Y/Z of a camera that does nothing else.
std::optional<Eigen::Matrix3d> linear_part(const Camera& camera) {
  const auto& p = camera.params;
  const auto bends = [&](int param) {
    const bool is_linear = param == Camera::kF || param == Camera::kCx || param == Camera::kCy ||
                           param == Camera::kB1 || param == Camera::kB2;
    return !is_linear && p[std::size_t(param)] != 0;
  };
  if (is_fisheye(camera.model) || std::ranges::any_of(params_of(camera), bends)) return std::nullopt;
  Eigen::Matrix3d out;
  out << p[Camera::kF] + p[Camera::kB1], p[Camera::kB2], p[Camera::kCx], 0, p[Camera::kF], p[Camera::kCy], 0, 0, 1;
  return out;
}

}  // namespace

EpipolarLines::EpipolarLines(const Rigid3& second_from_first, const Matrix5& covariance) : covariance_(covariance) {
  const Eigen::Matrix3d rotation = second_from_first.rotation.toRotationMatrix();
  const Eigen::Vector3d base = base_in_first(second_from_first);
  essential_ = -rotation * skew(base);
  for (int i = 0; i < 3; ++i) by_change_[std::size_t(i)] = skew(Eigen::Vector3d::Unit(i)) * essential_;
  const Eigen::Matrix<double, 3, 2> tangents = tangents_of(base);
  for (int i = 0; i < 2; ++i) by_change_[std::size_t(3 + i)] = -rotation * skew(tangents.col(i));
}

std::optional<Eigen::Vector3d> EpipolarLines::of(const Eigen::Vector2d& first) const {
  const Eigen::Vector3d line = essential_ * first.homogeneous();
  const double norm = line.head<2>().norm();
  if (!(norm > 1e-12)) return std::nullopt;
  return line / norm;
}

Vector5 EpipolarLines::distance_by_change(const Eigen::Vector2d& first, const Eigen::Vector2d& second) const {
  const Eigen::Vector3d ray = first.homogeneous(), seen = second.homogeneous();
  const double norm = (essential_ * ray).head<2>().norm();
  Vector5 by;
  for (int i = 0; i < 5; ++i) by[i] = seen.dot(by_change_[std::size_t(i)] * ray) / norm;
  return by;
}

double EpipolarLines::sigma(const Eigen::Vector2d& first, const Eigen::Vector2d& second) const {
  const Vector5 by = distance_by_change(first, second);
  return std::sqrt(std::max(by.dot(covariance_ * by), 0.0));
}

std::optional<Eigen::Matrix3d> fundamental_matrix(const Camera& first, const Camera& second,
                                                  const Rigid3& second_from_first) {
  const auto of_first = linear_part(first), of_second = linear_part(second);
  if (!of_first || !of_second) return std::nullopt;
  const Eigen::Matrix3d rotation = second_from_first.rotation.toRotationMatrix();
  const Eigen::Matrix3d essential = -rotation * skew(base_in_first(second_from_first));
  return (of_second->inverse().transpose() * essential * of_first->inverse()).normalized();
}

}  // namespace collinea
