// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>

#include "collinea/restitution/plotted_vertex.h"

namespace collinea {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Matrix36 = Eigen::Matrix<double, 3, 6>;

constexpr std::size_t kNeighbours = 4;  // of a vertex, that hold the images named to each other

// What is left of everything without what the poses add: nothing below zero.
Matrix3d left_of(const Matrix3d& all, const Matrix3d& of_poses) {
  const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(0.5 * (all - of_poses + (all - of_poses).transpose()));
  return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0).asDiagonal() * eigen.eigenvectors().transpose();
}

}  // namespace

std::vector<ImageId> VertexPlotter::nearest(const Vector3d& position_in_world, std::size_t most) const {
  std::vector<std::pair<double, ImageId>> seeing;
  for (const OrientedImage& one : oriented_images(marking_.block)) {
    const auto linear = linear_pixel(marking_.block.camera_of(one.image), one.cam_from_world, position_in_world);
    if (!linear || !inside(marking_.block.camera_of(one.image), linear->pixel)) continue;
    seeing.emplace_back((centre_of(one.cam_from_world) - position_in_world).norm(), one.image);
  }
  std::sort(seeing.begin(), seeing.end());
  if (seeing.size() > most) seeing.resize(most);
  std::vector<ImageId> images;
  for (const auto& [distance, image] : seeing) images.push_back(image);
  return images;
}

std::vector<std::pair<ImageId, Matrix36>> VertexPlotter::moved_by_poses(const Vector3d& position_in_world) const {
  std::vector<std::pair<ImageId, LinearPixel>> seen;
  Matrix3d normal = Matrix3d::Zero();
  for (const ImageId image : nearest(position_in_world, kNearest)) {
    const auto linear =
        linear_pixel(marking_.block.camera_of(image), pose_of(marking_.block, image), position_in_world);
    normal += linear->by_point.transpose() * linear->by_point;
    seen.emplace_back(image, *linear);
  }
  // Of one image, or of some from one place, no depth.
  constexpr double kLeast = 1e-6;
  const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(normal);
  if (!(eigen.eigenvalues()[0] > kLeast * eigen.eigenvalues()[2])) return {};
  const Matrix3d inverse = normal.inverse();
  std::vector<std::pair<ImageId, Matrix36>> moved;
  for (const auto& [image, linear] : seen)
    moved.emplace_back(image, -inverse * linear.by_point.transpose() * linear.by_pose);
  return moved;
}

// Those that errors name come first; neighbours as long as there is room.
std::vector<ImageId> VertexPlotter::images_of(std::span<const PlottedVertex> vertices) const {
  std::vector<ImageId> images;
  const auto take = [&](ImageId image) {
    if (std::find(images.begin(), images.end(), image) == images.end()) images.push_back(image);
  };
  for (const PlottedVertex& vertex : vertices)
    if (vertex.errors)
      for (const auto& [image, by_pose] : vertex.errors->by_pose) take(image);
  if (images.empty() || images.size() > kMostImages) return images;
  for (const PlottedVertex& vertex : vertices)
    for (const ImageId image : nearest(vertex.position_in_world, kNeighbours))
      if (images.size() < kMostImages) take(image);
  std::sort(images.begin(), images.end());
  return images;
}

const std::optional<LocalPoses>& VertexPlotter::poses_of(const std::vector<ImageId>& images) {
  static const std::optional<LocalPoses> none;
  if (marking_.poses.empty()) return none;  // run adjust
  const auto known = poses_.find(images);
  if (known != poses_.end()) return known->second;
  return poses_
      .emplace(images, local_poses(marking_.block, marking_.observations, images, marking_.poses, marking_.sigma0))
      .first->second;
}

Result<MatrixXd> VertexPlotter::covariance(std::span<const PlottedVertex> vertices) {
  if (vertices.size() > kMostVertices)
    return fail(Errc::kUnsupported,
                "more than " + std::to_string(kMostVertices) + " vertices: measure parts of the figure");
  for (const PlottedVertex& vertex : vertices)
    if (!vertex.errors) return fail(Errc::kIllPosed, "the errors of a vertex are not known");
  const std::vector<ImageId> images = images_of(vertices);
  const Index size = 3 * Index(vertices.size());
  if (images.size() > kMostImages)
    return fail(Errc::kUnsupported, "the vertices are of more than " + std::to_string(kMostImages) +
                                        " images: measure parts of the figure");
  MatrixXd all = MatrixXd::Zero(size, size);
  if (!images.empty()) {
    const std::optional<LocalPoses>& local = poses_of(images);
    if (!local) return fail(Errc::kIllPosed, "the covariance of the poses is not known");
    MatrixXd by_poses = MatrixXd::Zero(size, 6 * Index(images.size()));
    for (std::size_t i = 0; i < vertices.size(); ++i)
      for (const auto& [image, by_pose] : vertices[i].errors->by_pose) {
        const auto column = std::find(images.begin(), images.end(), image) - images.begin();
        by_poses.block<3, 6>(3 * Index(i), 6 * Index(column)) += by_pose;
      }
    all = by_poses * local->covariance * by_poses.transpose();
  }
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const VertexErrors& errors = *vertices[i].errors;
    const Index at = 3 * Index(i);
    const Matrix3d of_poses = all.block<3, 3>(at, at);
    all.block<3, 3>(at, at) += errors.is_of_all ? left_of(errors.covariance_m2, of_poses) : errors.covariance_m2;
  }
  return all;
}

std::optional<Matrix3d> VertexPlotter::covariance_in_map(const PlottedVertex& vertex) {
  const auto in_world_axes = covariance({&vertex, 1});
  if (!in_world_axes) return std::nullopt;
  const Matrix3d turn = map_by_world(vertex.position_in_world);
  const Matrix3d c = turn * *in_world_axes * turn.transpose();
  return Matrix3d(0.5 * (c + c.transpose()));
}

}  // namespace collinea
