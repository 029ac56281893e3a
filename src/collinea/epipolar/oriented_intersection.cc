// SPDX-License-Identifier: Apache-2.0
#include "collinea/epipolar/oriented_intersection.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "collinea/epipolar/intersect_rays.h"
#include "collinea/geometry/rotation.h"

namespace collinea {
namespace {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

struct Equations {
  Matrix23 by_point;
  Vector2d misfit;
  Matrix2d covariance, weight;
};

std::optional<Equations> equations_of(const UncertainSightLine& uncertain, const Vector3d& point) {
  const SightLine& line = uncertain.line;
  const Matrix3d rotation = line.cam_from_world.rotation.toRotationMatrix();
  Matrix23 by_cam;
  const auto pixel = project(*line.camera, line.cam_from_world * point, &by_cam, nullptr);
  if (!pixel) return std::nullopt;
  Equations e;
  e.by_point = by_cam * rotation;
  e.misfit = line.pixel - *pixel;
  Eigen::Matrix<double, 2, 6> by_pose;
  by_pose << e.by_point * skew(point - centre_of(line.cam_from_world)), -e.by_point;
  const Matrix2d root = line.shape.whitening().inverse();
  e.covariance = line.sigma_px * line.sigma_px * root * root.transpose() +
                 by_pose * uncertain.pose_covariance * by_pose.transpose();
  const Eigen::LLT<Matrix2d> factor(e.covariance);
  if (factor.info() != Eigen::Success) return std::nullopt;
  e.weight = factor.solve(Matrix2d::Identity());
  return e;
}

}  // namespace

std::optional<OrientedIntersection> intersect_oriented(std::span<const UncertainSightLine> lines) {
  std::vector<SightLine> plain;
  std::vector<Rigid3> poses;
  for (const UncertainSightLine& one : lines) {
    plain.push_back(one.line);
    poses.push_back(one.line.cam_from_world);
  }
  const auto start = intersect(plain);
  if (!start) return std::nullopt;
  OrientedIntersection out;
  out.point_in_world = start->point_in_world;
  std::vector<Equations> equations(lines.size());
  double cost = 0;
  for (int iteration = 0; iteration < 30; ++iteration) {
    Matrix3d normal = Matrix3d::Zero();
    Vector3d right = Vector3d::Zero();
    cost = 0;
    for (std::size_t i = 0; i < lines.size(); ++i) {
      const auto e = equations_of(lines[i], out.point_in_world);
      if (!e) return std::nullopt;
      equations[i] = *e;
      normal += e->by_point.transpose() * e->weight * e->by_point;
      right += e->by_point.transpose() * e->weight * e->misfit;
      cost += e->misfit.dot(e->weight * e->misfit);
    }
    const Eigen::LDLT<Matrix3d> factor(normal);
    if (!(factor.vectorD().minCoeff() > 0)) return std::nullopt;
    out.covariance = factor.solve(Matrix3d::Identity());
    const Vector3d step = factor.solve(right);
    if (!step.allFinite()) return std::nullopt;
    if (step.dot(normal * step) < 1e-16 * std::max(1.0, cost)) break;
    out.point_in_world += step;
  }
  for (const Equations& e : equations) {
    const Matrix2d left = e.covariance - e.by_point * out.covariance * e.by_point.transpose();
    const Matrix2d redundancy = left * e.weight, of_multipliers = e.weight * redundancy;
    const Vector2d multipliers = e.weight * e.misfit;
    RayTest test{e.misfit, redundancy.diagonal().cwiseMax(0)};
    for (int k = 0; k < 2; ++k)
      if (of_multipliers(k, k) > 1e-9 * e.weight(k, k)) test.w[k] = multipliers[k] / std::sqrt(of_multipliers(k, k));
    out.rays.push_back(test);
  }
  out.redundancy = 2 * static_cast<int>(lines.size()) - 3;
  out.sigma0 = std::sqrt(cost / out.redundancy);
  out.max_angle_rad = max_ray_angle_rad(poses, out.point_in_world);
  return out;
}

}  // namespace collinea
