// SPDX-License-Identifier: Apache-2.0
#include "collinea/assess/internal/pose_errors.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/geometry/rotation.h"

namespace collinea {
namespace {

struct Ray {
  Eigen::Vector3d origin, direction;  // in world
};

struct Measured {
  const Camera* camera;
  Rigid3 cam_from_world;
  const ControlObservation* observation;
};

std::vector<Measured> measurements_of(const Block& block, ControlId mark) {
  std::vector<Measured> found;
  for (const ControlObservation& observation : block.control_observations) {
    if (observation.point != mark) continue;
    if (const std::optional<Rigid3> pose = find_pose(block, observation.image))
      found.push_back({&block.camera_of(observation.image), *pose, &observation});
  }
  return found;
}

// The point nearest to all rays.
std::optional<Eigen::Vector3d> nearest_to_rays(const std::vector<Measured>& measured) {
  Eigen::Matrix3d normals = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const Measured& m : measured) {
    const Eigen::Vector3d direction =
        m.cam_from_world.rotation.conjugate() * ray_in_cam(*m.camera, m.observation->pixel);
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - direction * direction.transpose();
    normals += across;
    right += across * centre_of(m.cam_from_world);
  }
  const double smallest = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(normals).eigenvalues()[0];
  if (!(smallest > 1e-6)) return std::nullopt;
  return normals.inverse() * right;
}

}  // namespace

PointErrors point_errors(std::span<const Eigen::Vector3d> estimated, std::span<const Eigen::Vector3d> truth) {
  COLLINEA_CHECK(estimated.size() == truth.size());
  PointErrors errors;
  errors.points = estimated.size();
  if (estimated.empty()) return errors;
  Eigen::Vector3d squares = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < estimated.size(); ++i) {
    const Eigen::Vector3d e = estimated[i] - truth[i];
    errors.mean_m += e;
    squares += e.cwiseProduct(e);
    errors.worst_3d_m = std::max(errors.worst_3d_m, e.norm());
  }
  const auto n = double(estimated.size());
  errors.mean_m /= n;
  errors.rms_m = (squares / n).cwiseSqrt();
  errors.rms_3d_m = std::sqrt(squares.sum() / n);
  return errors;
}

PoseErrors pose_errors(const Block& block, const std::map<std::string, Rigid3>& true_cam_from_world,
                       const ToTruth& to_truth) {
  PoseErrors errors;
  errors.images = true_cam_from_world.size();
  std::vector<Eigen::Vector3d> estimated, in_truth, truth;
  std::vector<std::pair<Rigid3, Rigid3>> poses;
  for (const auto& [id, pose] : oriented_images(block)) {
    const auto found = true_cam_from_world.find(std::filesystem::path(block.images.at(id).file).filename().string());
    if (found == true_cam_from_world.end()) continue;
    estimated.push_back(centre_of(pose));
    if (to_truth) in_truth.push_back(to_truth(estimated.back()));
    truth.push_back(centre_of(found->second));
    poses.emplace_back(pose, found->second);
  }
  errors.oriented = estimated.size();
  if (to_truth && !estimated.empty()) errors.centres = point_errors(in_truth, truth);
  const auto truth_from_estimate = align(estimated, truth);
  if (!truth_from_estimate) return errors;
  for (Eigen::Vector3d& p : estimated) p = *truth_from_estimate * p;
  errors.after_similarity = point_errors(estimated, truth);
  errors.scale = truth_from_estimate->scale;
  double squares = 0;
  for (const auto& [pose, true_pose] : poses)
    squares += std::pow(angle_between(moved(pose, *truth_from_estimate).rotation, true_pose.rotation), 2);
  errors.rotation_rms_deg = std::sqrt(squares / double(poses.size())) * 180 / std::numbers::pi;
  return errors;
}

std::optional<Eigen::Vector3d> intersect_mark(const Block& block, ControlId mark) {
  const std::vector<Measured> measured = measurements_of(block, mark);
  if (measured.size() < 2) return std::nullopt;
  auto point = nearest_to_rays(measured);
  if (!point) return std::nullopt;
  for (int iteration = 0; iteration < 10; ++iteration) {
    Eigen::Matrix3d normals = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (const Measured& m : measured) {
      Matrix23 by_cam_point;
      const auto pixel = project(*m.camera, m.cam_from_world * *point, &by_cam_point, nullptr);
      if (!pixel) return std::nullopt;
      const Matrix23 by_point = by_cam_point * m.cam_from_world.rotation.toRotationMatrix();
      const double weight = 1 / (m.observation->sigma_px * m.observation->sigma_px);
      normals += weight * by_point.transpose() * by_point;
      right += weight * by_point.transpose() * (m.observation->pixel - *pixel);
    }
    const Eigen::Vector3d step = normals.inverse() * right;
    if (!step.allFinite()) return std::nullopt;
    *point += step;
    if (step.norm() < 1e-10 * (1 + point->norm())) break;
  }
  return point;
}

PointErrors mark_errors(const Block& block, ControlRole role, const std::map<std::string, Eigen::Vector3d>& true_marks,
                        const ToTruth& to_truth) {
  std::vector<Eigen::Vector3d> estimated, truth;
  for (const auto& [id, mark] : block.control) {
    const auto found = true_marks.find(mark.name);
    if (mark.role != role || found == true_marks.end()) continue;
    const auto point = intersect_mark(block, id);
    if (!point) continue;
    estimated.push_back(to_truth(*point));
    truth.push_back(found->second);
  }
  return point_errors(estimated, truth);
}

}  // namespace collinea
