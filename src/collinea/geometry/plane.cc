// SPDX-License-Identifier: Apache-2.0
#include "collinea/geometry/plane.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "collinea/math/random.h"

namespace collinea {

using Eigen::Vector3d;

FramedPlane framed_plane(const Vector3d& origin_in_world, const Vector3d& normal_in_world,
                         const Vector3d& up_in_world) {
  constexpr double kLevel = 0.98481;  // cosine of 10 degrees
  const Vector3d z = normal_in_world.normalized(), up = up_in_world.normalized();
  Vector3d towards = std::abs(z.dot(up)) > kLevel ? Vector3d::UnitY() : up;
  if (std::abs(z.dot(towards)) > kLevel) towards = Vector3d::UnitX();  // level, and north is nearly up: any does
  const Vector3d y = (towards - z * z.dot(towards)).normalized();
  FramedPlane plane;
  plane.origin_in_world = origin_in_world;
  plane.world_from_plane << y.cross(z), y, z;
  return plane;
}

std::optional<PlaneFit> fit_plane(std::span<const Vector3d> points) {
  if (points.size() < 3) return {};
  PlaneFit fit;
  fit.middle.setZero();
  for (const Vector3d& p : points) fit.middle += p;
  fit.middle /= double(points.size());
  Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();
  for (const Vector3d& p : points) moments += (p - fit.middle) * (p - fit.middle).transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(moments);
  if (!(axes.eigenvalues()[1] > 1e-6 * axes.eigenvalues()[2])) return {};
  fit.normal = axes.eigenvectors().col(0);
  double squares = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    squares += std::pow(fit.normal.dot(points[i] - fit.middle), 2);
    fit.points.push_back(i);
  }
  fit.rms_m = std::sqrt(squares / double(points.size()));
  return fit;
}

std::optional<PlaneFit> find_plane(std::span<const Vector3d> points, double tolerance_m, std::uint64_t seed) {
  constexpr int kSamples = 500;  // finds a plane of a fifth of the points with 98 %
  constexpr double kLeastShare = 0.1;
  constexpr std::size_t kJudged = 5000;
  if (points.size() < 3) return {};
  Random random(seed);
  const auto any = [&] { return points[random.below(std::uint32_t(points.size()))]; };
  const std::size_t stride = std::max<std::size_t>(1, points.size() / kJudged);
  Vector3d middle, normal;
  std::size_t most = 0;
  for (int sample = 0; sample < kSamples; ++sample) {
    const Vector3d a = any(), across = (any() - a).cross(any() - a);
    if (!(across.norm() > 0)) continue;
    const Vector3d n = across.normalized();
    std::size_t on_it = 0;
    for (std::size_t i = 0; i < points.size(); i += stride) on_it += std::abs(n.dot(points[i] - a)) <= tolerance_m;
    if (on_it > most) most = on_it, middle = a, normal = n;
  }
  if (most == 0) return {};
  std::optional<PlaneFit> fit;
  for (int round = 0; round < 3; ++round) {
    std::vector<Vector3d> near;
    std::vector<std::size_t> which;
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (std::abs(normal.dot(points[i] - middle)) > tolerance_m) continue;
      near.push_back(points[i]);
      which.push_back(i);
    }
    if (double(near.size()) < kLeastShare * double(points.size())) return {};
    fit = fit_plane(near);
    if (!fit) return {};
    fit->points = std::move(which);
    middle = fit->middle, normal = fit->normal;
  }
  return fit;
}

}  // namespace collinea
