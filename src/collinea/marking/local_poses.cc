// SPDX-License-Identifier: Apache-2.0
#include "collinea/marking/local_poses.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "collinea/geometry/rotation.h"
#include "collinea/math/median.h"

namespace collinea {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Matrix63 = Eigen::Matrix<double, 6, 3>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr std::size_t kMostTies = 6000;  // more stand for themselves: their precision is that of thousands

/// A tie point as some of the images see it.
struct LocalTie {
  PointId point;
  std::vector<std::pair<std::size_t, std::size_t>> seen;  // index of the image, index in Block::observations
};

std::vector<LocalTie> local_ties(const Block& block, const std::map<ImageId, std::vector<std::size_t>>& observations,
                                 std::span<const ImageId> images) {
  std::map<PointId, LocalTie> ties;
  for (std::size_t i = 0; i < images.size(); ++i) {
    const auto found = observations.find(images[i]);
    if (found == observations.end()) continue;
    for (const std::size_t o : found->second) {
      LocalTie& tie = ties[block.observations[o].point];
      tie.point = block.observations[o].point;
      tie.seen.emplace_back(i, o);
    }
  }
  std::vector<LocalTie> shared;
  for (auto& [id, tie] : ties)
    if (tie.seen.size() >= 2 && block.points.contains(id)) shared.push_back(std::move(tie));
  return shared;
}

// Adds the reduced normals of one tie point, its position eliminated.
void add_tie(const Block& block, const LocalPoses& local, const LocalTie& tie, double times, MatrixXd& normals) {
  struct Ray {
    Eigen::Index at;
    Matrix6 pose;
    Matrix63 mixed;
  };
  std::vector<Ray> rays;
  Matrix3d by_point = Matrix3d::Zero();
  const Vector3d position = block.points.at(tie.point).position_in_world;
  for (const auto& [image, o] : tie.seen) {
    const Observation& seen = block.observations[o];
    const auto linear = linear_pixel(block.camera_of(seen.image), local.cam_from_world[image], position);
    if (!linear || !(seen.sigma_px > 0)) continue;
    const Eigen::Matrix2d whitening = seen.shape.whitening() / seen.sigma_px;
    const Eigen::Matrix<double, 2, 3> a = whitening * linear->by_point;
    const Eigen::Matrix<double, 2, 6> b = whitening * linear->by_pose;
    by_point += a.transpose() * a;
    rays.push_back({6 * Eigen::Index(image), b.transpose() * b, b.transpose() * a});
  }
  const Eigen::LLT<Matrix3d> factor(by_point);
  if (rays.size() < 2 || factor.info() != Eigen::Success) return;
  const Matrix3d inverse = factor.solve(Matrix3d::Identity());
  for (const Ray& one : rays) {
    normals.block<6, 6>(one.at, one.at) += times * one.pose;
    for (const Ray& other : rays)
      normals.block<6, 6>(one.at, other.at) -= times * one.mixed * inverse * other.mixed.transpose();
  }
}

// What is known of where the images lie as a whole, for each of them.
Matrix6 loose_information(const LocalPoses& local, const std::vector<LocalTie>& ties, const Block& block) {
  std::vector<double> distances;
  for (const LocalTie& tie : ties)
    distances.push_back(
        (block.points.at(tie.point).position_in_world - centre_of(local.cam_from_world[tie.seen.front().first]))
            .norm());
  const double sigma = 0.1 * (distances.empty() ? 1 : median(distances));
  Eigen::Matrix<double, 6, 1> diagonal;
  diagonal << Vector3d::Constant(1 / (kLooseRotation_rad * kLooseRotation_rad)),
      Vector3d::Constant(1 / (sigma * sigma));
  return diagonal.asDiagonal();
}

}  // namespace

std::optional<LinearPixel> linear_pixel(const Camera& camera, const Rigid3& cam_from_world,
                                        const Vector3d& point_in_world, Matrix2P* by_camera) {
  Matrix23 by_cam;
  const auto pixel = project(camera, cam_from_world * point_in_world, &by_cam, by_camera);
  if (!pixel || !pixel->allFinite()) return std::nullopt;
  LinearPixel out;
  out.pixel = *pixel;
  out.by_point = by_cam * cam_from_world.rotation.toRotationMatrix();
  out.by_pose << -out.by_point * skew(point_in_world - centre_of(cam_from_world)), -out.by_point;
  return out;
}

std::optional<LocalPoses> local_poses(const Block& block,
                                      const std::map<ImageId, std::vector<std::size_t>>& observations,
                                      std::span<const ImageId> images, const PoseCovariances& poses, double sigma0) {
  LocalPoses local;
  for (const ImageId image : images) {
    const auto pose = find_pose(block, image);
    if (!pose) return std::nullopt;
    local.images.push_back(image);
    local.cam_from_world.push_back(*pose);
  }
  if (images.empty()) return std::nullopt;
  const std::vector<LocalTie> ties = local_ties(block, observations, images);
  const Eigen::Index size = 6 * Eigen::Index(images.size());
  MatrixXd normals = MatrixXd::Zero(size, size);
  const std::size_t step = std::max<std::size_t>(1, ties.size() / kMostTies);
  for (std::size_t i = 0; i < ties.size(); i += step) add_tie(block, local, ties[i], double(step), normals);
  const Matrix6 loose = loose_information(local, ties, block);
  for (std::size_t i = 0; i < images.size(); ++i) {
    const auto known = poses.find(images[i]);
    const Eigen::LLT<Matrix6> factor(known == poses.end() ? Matrix6::Identity().eval() : known->second);
    const bool usable = known != poses.end() && factor.info() == Eigen::Success;
    const Matrix6 information = usable ? Matrix6(factor.solve(Matrix6::Identity())) : Matrix6(loose * sigma0 * sigma0);
    normals.block<6, 6>(6 * Eigen::Index(i), 6 * Eigen::Index(i)) += information / double(images.size());
  }
  const Eigen::LLT<MatrixXd> factor(normals);
  if (factor.info() != Eigen::Success) return std::nullopt;
  local.information = normals / (sigma0 * sigma0);
  local.covariance = sigma0 * sigma0 * factor.solve(MatrixXd::Identity(size, size));
  return local;
}

}  // namespace collinea
