// SPDX-License-Identifier: Apache-2.0
#include "collinea/epipolar/intersect.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace collinea {
namespace {

constexpr double kLeastAngle_rad = 1e-4;  // between sight lines that shall fix a depth

// The point nearest to all lines in space; nothing when they are nearly parallel.
std::optional<Eigen::Vector3d> nearest_point(std::span<const SightLine> lines) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero(), origin = Eigen::Vector3d::Zero();
  for (const SightLine& line : lines) origin += centre_of(line.cam_from_world) / double(lines.size());
  for (const SightLine& line : lines) {
    const Eigen::Vector3d ray = line.cam_from_world.rotation.conjugate() * ray_in_cam(*line.camera, line.pixel);
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - ray * ray.transpose();
    normal += across;
    right += across * (centre_of(line.cam_from_world) - origin);
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(normal);
  // n rays within an angle a of one direction leave an eigenvalue of the order n a^2.
  if (!(eigen.eigenvalues()[0] > double(lines.size()) * kLeastAngle_rad * kLeastAngle_rad / 4)) return std::nullopt;
  return origin + normal.ldlt().solve(right);
}

struct Normals {
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  double cost = 0;
  bool seen = true;
};

Normals normals_at(std::span<const SightLine> lines, const Eigen::Vector3d& point,
                   std::vector<Eigen::Vector2d>* residuals) {
  Normals normals;
  if (residuals) residuals->clear();
  for (const SightLine& line : lines) {
    Matrix23 by_point;
    const auto pixel = project(*line.camera, line.cam_from_world * point, &by_point, nullptr);
    if (!pixel) {
      normals.seen = false;
      return normals;
    }
    const double weight = 1 / (line.sigma_px * line.sigma_px);
    const Matrix23 by_world = by_point * line.cam_from_world.rotation.toRotationMatrix();
    const Eigen::Vector2d residual = line.pixel - *pixel;
    if (line.shape.is_round()) {
      normals.matrix += weight * by_world.transpose() * by_world;
      normals.right += weight * by_world.transpose() * residual;
      normals.cost += weight * residual.squaredNorm();
    } else {
      const Eigen::Matrix2d whitening = line.shape.whitening();
      const Matrix23 by = whitening * by_world;
      const Eigen::Vector2d independent = whitening * residual;
      normals.matrix += weight * by.transpose() * by;
      normals.right += weight * by.transpose() * independent;
      normals.cost += weight * independent.squaredNorm();
    }
    if (residuals) residuals->push_back(residual);
  }
  return normals;
}

}  // namespace

std::optional<Intersection> intersect(std::span<const SightLine> lines) {
  if (lines.size() < 2) return std::nullopt;
  std::optional<Eigen::Vector3d> point = nearest_point(lines);
  if (!point) return std::nullopt;
  Normals normals = normals_at(lines, *point, nullptr);
  if (!normals.seen) return std::nullopt;
  for (int iteration = 0; iteration < 20; ++iteration) {
    Eigen::Vector3d step = normals.matrix.ldlt().solve(normals.right);
    Normals next;
    int halvings = 0;
    for (; halvings < 8; ++halvings, step /= 4) {
      next = normals_at(lines, *point + step, nullptr);
      if (next.seen && next.cost <= normals.cost) break;
    }
    if (halvings == 8) break;
    const bool settled = normals.cost - next.cost <= 1e-14 * normals.cost;
    *point += step;
    normals = next;
    if (settled) break;
  }
  Intersection result;
  result.point_in_world = *point;
  normals = normals_at(lines, *point, &result.residuals_px);
  result.covariance = normals.matrix.ldlt().solve(Eigen::Matrix3d::Identity());
  if (!result.covariance.allFinite()) return std::nullopt;
  result.sigma0 = std::sqrt(normals.cost / double(2 * lines.size() - 3));
  return result;
}

std::vector<SightLine> sight_lines(const Block& block, ControlId point, std::vector<std::size_t>* indices) {
  std::vector<SightLine> lines;
  if (indices) indices->clear();
  for (std::size_t i = 0; i < block.control_observations.size(); ++i) {
    const ControlObservation& observation = block.control_observations[i];
    if (observation.point != point) continue;
    const std::optional<Rigid3> pose = find_pose(block, observation.image);
    if (!pose) continue;
    lines.push_back(
        {&block.camera_of(observation.image), *pose, observation.pixel, observation.sigma_px, observation.shape});
    if (indices) indices->push_back(i);
  }
  return lines;
}

}  // namespace collinea
