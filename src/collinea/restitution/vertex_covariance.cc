// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>

#include "collinea/epipolar/intersect.h"
#include "collinea/restitution/plotted_vertex.h"

namespace collinea {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;

constexpr std::size_t kNeighbours = 4;  // of a vertex, that hold the images named to each other

// What is left of everything without what the images add: nothing below zero.
Matrix3d left_of(const Matrix3d& all, const Matrix3d& of_images) {
  const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(0.5 * (all - of_images + (all - of_images).transpose()));
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

MovedByImages VertexPlotter::moved_with_images(const Vector3d& position_in_world) const {
  struct Seen {
    ImageId image;
    LinearPixel linear;
    Matrix2P by_camera;
  };
  const Block& block = marking_.block;
  std::vector<Seen> seen;
  Matrix3d normal = Matrix3d::Zero();
  for (const ImageId image : nearest(position_in_world, kNearest)) {
    Matrix2P by_camera;
    const auto linear = linear_pixel(block.camera_of(image), pose_of(block, image), position_in_world, &by_camera);
    normal += linear->by_point.transpose() * linear->by_point;
    seen.push_back({image, *linear, by_camera});
  }
  // Of one image, or of some from one place, no depth.
  constexpr double kLeast = 1e-6;
  const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(normal);
  if (!(eigen.eigenvalues()[0] > kLeast * eigen.eigenvalues()[2])) return {};
  const Matrix3d inverse = normal.inverse();
  MovedByImages moved;
  for (const Seen& one : seen) {
    const Eigen::Matrix<double, 3, 2> gain = inverse * one.linear.by_point.transpose();
    moved.add(one.image, -gain * one.linear.by_pose, block.images.at(one.image).camera, -gain * one.by_camera);
  }
  return moved;
}

// What the adjustment of the whole block knows needs no neighbours; else they hold the images named to each other.
void VertexPlotter::add_neighbours(const Vector3d& position_in_world, std::vector<ImageId>& images) const {
  if (marking_.poses_together) return;
  for (const ImageId image : nearest(position_in_world, kNeighbours))
    if (images.size() < kMostImages && std::ranges::find(images, image) == images.end()) images.push_back(image);
}

// Those of the marks, sorted; nothing where neighbours are needed and the rays do not say whose.
std::optional<std::vector<ImageId>> VertexPlotter::images_of(std::span<const ImageMark> marks) const {
  const Block& block = marking_.block;
  std::vector<ImageId> images;
  for (const ImageMark& mark : marks)
    if (std::ranges::find(images, mark.image) == images.end()) images.push_back(mark.image);
  if (!marking_.poses_together) {
    std::vector<SightLine> lines;
    for (const ImageMark& mark : marks)
      lines.push_back({&block.camera_of(mark.image), pose_of(block, mark.image), mark.pixel, mark.sigma_px, {}});
    const auto met = intersect(lines);
    if (!met) return std::nullopt;
    add_neighbours(met->point_in_world, images);
  }
  std::ranges::sort(images);
  return images;
}

// Those that errors name come first; neighbours as long as there is room.
std::vector<ImageId> VertexPlotter::images_of(std::span<const PlottedVertex> vertices) const {
  std::vector<ImageId> images;
  for (const PlottedVertex& vertex : vertices)
    if (vertex.errors)
      for (const auto& [image, by_pose] : vertex.errors->by_images.by_pose)
        if (std::ranges::find(images, image) == images.end()) images.push_back(image);
  if (images.empty() || images.size() > kMostImages) return images;
  for (const PlottedVertex& vertex : vertices) add_neighbours(vertex.position_in_world, images);
  std::ranges::sort(images);
  return images;
}

const std::optional<JointPoses>& VertexPlotter::poses_of(const std::vector<ImageId>& images) {
  static const std::optional<JointPoses> none;
  if (marking_.poses.empty() && !marking_.poses_together) return none;  // run adjust
  const auto known = poses_.find(images);
  if (known != poses_.end()) return known->second;
  if (poses_.size() >= kMostKept) poses_.clear();
  std::optional<JointPoses> joint;
  if (marking_.poses_together) {
    joint = marking_.poses_together(images);
    if (joint) joint->covariance *= marking_.sigma0 * marking_.sigma0;
  } else if (auto local = local_poses(marking_.block, marking_.observations, images, marking_.poses, marking_.sigma0)) {
    joint = JointPoses{.images = std::move(local->images), .covariance = std::move(local->covariance)};
  }
  return poses_.emplace(images, std::move(joint)).first->second;
}

namespace {

// How the errors of images, in the order of their covariance, move a vertex.
MatrixXd by_all(const MovedByImages& moved, const JointPoses& images) {
  MatrixXd by = MatrixXd::Zero(3, images.covariance.cols());
  for (const auto& [image, by_pose] : moved.by_pose)
    by.middleCols<6>(6 * (std::ranges::find(images.images, image) - images.images.begin())) = by_pose;
  auto column = 6 * Index(images.images.size());
  for (const JointPoses::FreeCamera& camera : images.cameras) {
    const auto its =
        std::ranges::find(moved.by_camera, camera.camera, &std::pair<CameraId, MovedByImages::ByCamera>::first);
    for (const int param : camera.params) {
      if (its != moved.by_camera.end()) by.col(column) = its->second.col(param);
      ++column;
    }
  }
  return by;
}

}  // namespace

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
    const std::optional<JointPoses>& joint = poses_of(images);
    if (!joint) return fail(Errc::kIllPosed, "the covariance of the poses is not known");
    MatrixXd by_images(size, joint->covariance.cols());
    for (std::size_t i = 0; i < vertices.size(); ++i)
      by_images.middleRows<3>(3 * Index(i)) = by_all(vertices[i].errors->by_images, *joint);
    all = by_images * joint->covariance * by_images.transpose();
  }
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const VertexErrors& errors = *vertices[i].errors;
    const Index at = 3 * Index(i);
    const Matrix3d of_images = all.block<3, 3>(at, at);
    all.block<3, 3>(at, at) += errors.is_of_all ? left_of(errors.covariance_m2, of_images) : errors.covariance_m2;
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
