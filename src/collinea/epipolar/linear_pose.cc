// SPDX-License-Identifier: Apache-2.0
#include "collinea/epipolar/linear_pose.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "collinea/geometry/rotation.h"
#include "collinea/geometry/similarity3.h"

namespace collinea {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using Matrix6 = Eigen::Matrix<double, 6, 6>;
using ByPixel = Eigen::Matrix<double, 6, 2>;  // of the pose by an image point
using ByPose = Eigen::Matrix<double, 2, 6>;   // of an image point by the pose

// What lies across all affine maps of the points: P = I - V V'.
struct Across {
  MatrixXd projector;
  bool is_plane = false;
};

std::optional<Across> across(std::span<const ProjectedPoint> points) {
  constexpr double kFlat = 1e-10;  // squared extent over the largest
  const auto n = static_cast<Eigen::Index>(points.size());
  Vector3d mean = Vector3d::Zero();
  for (const ProjectedPoint& point : points) mean += point.in_object / double(n);
  MatrixXd reduced(n, 3);
  for (Eigen::Index i = 0; i < n; ++i) reduced.row(i) = (points[std::size_t(i)].in_object - mean).transpose();
  const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(Matrix3d(reduced.transpose() * reduced));
  const Vector3d extent = eigen.eigenvalues();
  if (!(extent[1] > kFlat * extent[2])) return std::nullopt;
  Across out;
  out.is_plane = !(extent[0] > kFlat * extent[2]);
  const int dimensions = out.is_plane ? 2 : 3;
  if (n < (out.is_plane ? 4 : 6)) return std::nullopt;
  MatrixXd base(n, dimensions + 1);
  base.col(0).setConstant(1 / std::sqrt(double(n)));
  for (int k = 0; k < dimensions; ++k) base.col(k + 1) = (reduced * eigen.eigenvectors().col(2 - k)).normalized();
  out.projector = MatrixXd::Identity(n, n) - base * base.transpose();
  return out;
}

// Depths along (x, y, 1), and their derivatives by the image coordinates [x_0, y_0, x_1, ...].
struct Depths {
  VectorXd depth;
  MatrixXd by_image;
};

std::optional<Depths> depths_of(std::span<const ProjectedPoint> points, const MatrixXd& projector) {
  constexpr double kOpen = 1e-13;
  const auto n = static_cast<Eigen::Index>(points.size());
  Vector2d mean = Vector2d::Zero();
  for (const ProjectedPoint& point : points) mean += point.in_image / double(n);
  double spread = 0;
  for (const ProjectedPoint& point : points) spread += (point.in_image - mean).squaredNorm();
  if (!(spread > 0) || !std::isfinite(spread)) return std::nullopt;
  const double scale = std::sqrt(2 * double(n) / spread);
  MatrixXd rays(n, 3);
  for (Eigen::Index i = 0; i < n; ++i)
    rays.row(i) = (scale * (points[std::size_t(i)].in_image - mean)).homogeneous().transpose();
  const MatrixXd g = projector.cwiseProduct(rays * rays.transpose());
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(g);
  const VectorXd& values = eigen.eigenvalues();
  if (!(values[1] > kOpen * values[n - 1])) return std::nullopt;
  Depths out;
  out.depth = eigen.eigenvectors().col(0);
  if (out.depth.sum() < 0) out.depth = -out.depth;
  if (!(out.depth.minCoeff() > 0)) return std::nullopt;
  // dG l: of exact rays only the part r_i . dr_j is left.
  MatrixXd change(n, 2 * n);
  for (Eigen::Index j = 0; j < n; ++j)
    change.middleCols<2>(2 * j) = scale * out.depth[j] * projector.col(j).asDiagonal() * rays.leftCols<2>();
  const MatrixXd vectors = eigen.eigenvectors().rightCols(n - 1);
  out.by_image = -vectors * (values.tail(n - 1).cwiseInverse().asDiagonal() * (vectors.transpose() * change));
  return out;
}

// The pose by the similarity's [position of the centroid, rotation about the axes of the camera, ln scale].
Eigen::Matrix<double, 6, 7> pose_by_similarity(const Similarity3& cam_from_world, const Vector3d& centroid) {
  const Matrix3d back = cam_from_world.rotation.conjugate().toRotationMatrix();
  const Vector3d position = cam_from_world * centroid;
  Eigen::Matrix<double, 6, 7> by = Eigen::Matrix<double, 6, 7>::Zero();
  by.block<3, 3>(0, 3) = -back;
  by.block<3, 3>(3, 0) = -back / cam_from_world.scale;
  by.block<3, 3>(3, 3) = -back * skew(position) / cam_from_world.scale;
  by.block<3, 1>(3, 6) = back * position / cam_from_world.scale;
  return by;
}

// Derivatives of the pose by each image point: least squares of the similarity on the points at their depths.
std::vector<ByPixel> derivatives_of_pose(std::span<const ProjectedPoint> points, const Depths& depths,
                                         const Similarity3& cam_from_world) {
  const std::size_t n = points.size();
  Vector3d centroid = Vector3d::Zero();
  for (const ProjectedPoint& point : points) centroid += point.in_object / double(n);
  std::vector<Vector3d> arms;
  Matrix3d normal = Matrix3d::Zero();
  double spread = 0;
  for (const ProjectedPoint& point : points) {
    arms.push_back(cam_from_world.scale * (cam_from_world.rotation * (point.in_object - centroid)));
    normal += skew(arms.back()).transpose() * skew(arms.back());
    spread += arms.back().squaredNorm();
  }
  const Matrix3d inverse = normal.inverse();
  const Eigen::Matrix<double, 6, 7> to_pose = pose_by_similarity(cam_from_world, centroid);
  std::vector<Eigen::Matrix<double, 6, 3>> by_point;
  MatrixXd by_depth(6, static_cast<Eigen::Index>(n));
  for (std::size_t i = 0; i < n; ++i) {
    Eigen::Matrix<double, 7, 3> by;
    by << Matrix3d::Identity() / double(n), inverse * skew(arms[i]), arms[i].transpose() / spread;
    by_point.push_back(to_pose * by);
    by_depth.col(Eigen::Index(i)) = by_point.back() * points[i].in_image.homogeneous();
  }
  const MatrixXd through_depths = by_depth * depths.by_image;
  std::vector<ByPixel> out;
  for (std::size_t i = 0; i < n; ++i)
    out.push_back(through_depths.middleCols<2>(Eigen::Index(2 * i)) +
                  depths.depth[Eigen::Index(i)] * by_point[i].leftCols<2>());
  return out;
}

// An image point's derivatives by [rotation about the axes of the world, centre], and where it is computed.
ByPose rows_at(const Rigid3& cam_from_world, const Vector3d& point, Vector2d& computed) {
  const Vector3d p = cam_from_world * point;
  const Matrix3d turn = cam_from_world.rotation.toRotationMatrix();
  Eigen::Matrix<double, 2, 3> by_point;
  by_point << 1 / p.z(), 0, -p.x() / (p.z() * p.z()), 0, 1 / p.z(), -p.y() / (p.z() * p.z());
  computed = p.head<2>() / p.z();
  ByPose rows;
  rows << by_point * turn * skew(point - centre_of(cam_from_world)), -by_point * turn;
  return rows;
}

void add_residuals(std::span<const ProjectedPoint> points, const std::vector<ByPixel>& by_pixel, LinearPose& pose) {
  Matrix6 normal = Matrix6::Zero();
  Eigen::Matrix<double, 6, 1> right = Eigen::Matrix<double, 6, 1>::Zero();
  double squares = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    Vector2d computed;
    const ByPose rows = rows_at(pose.cam_from_world, points[i].in_object, computed);
    const Vector2d misfit = points[i].in_image - computed;
    const double variance = points[i].sigma * points[i].sigma;
    normal += rows.transpose() * rows / variance;
    right += rows.transpose() * misfit / variance;
    squares += misfit.squaredNorm() / variance;
    const Eigen::Matrix2d taken = rows * by_pixel[i] * variance;
    const Eigen::Matrix2d left =
        variance * Eigen::Matrix2d::Identity() - taken - taken.transpose() + rows * pose.covariance * rows.transpose();
    pose.misfits.push_back(misfit);
    pose.redundancies.push_back(Vector2d::Ones() - taken.diagonal() / variance);
    Vector2d w = Vector2d::Zero();
    for (int k = 0; k < 2; ++k)
      if (left(k, k) > 1e-9 * variance) w[k] = misfit[k] / std::sqrt(left(k, k));
    pose.w.push_back(w);
  }
  if (pose.redundancy <= 0) return;
  const Eigen::Matrix<double, 6, 1> unit = normal.diagonal().cwiseSqrt().cwiseInverse();
  const Matrix6 unit_normal = unit.asDiagonal() * normal * unit.asDiagonal();
  const Eigen::Matrix<double, 6, 1> scaled = unit.asDiagonal() * right;
  pose.sigma0 = std::sqrt(std::max(0.0, squares - scaled.dot(unit_normal.ldlt().solve(scaled))) / pose.redundancy);
}

// Whether the affine map between points in space has a reflection in it.
bool is_mirrored(const std::vector<Vector3d>& a, const std::vector<Vector3d>& b) {
  Vector3d mean = Vector3d::Zero();
  for (const Vector3d& point : a) mean += point / double(a.size());
  Matrix3d moments = Matrix3d::Zero();
  for (std::size_t i = 0; i < a.size(); ++i) moments += b[i] * (a[i] - mean).transpose();
  return !(moments.determinant() > 0);
}

}  // namespace

std::optional<LinearPose> linear_pose(std::span<const ProjectedPoint> points) {
  if (points.size() < 4) return std::nullopt;
  const auto open = across(points);
  if (!open) return std::nullopt;
  const auto depths = depths_of(points, open->projector);
  if (!depths) return std::nullopt;
  std::vector<Vector3d> in_world, in_camera;
  for (std::size_t i = 0; i < points.size(); ++i) {
    in_world.push_back(points[i].in_object);
    in_camera.emplace_back(depths->depth[Eigen::Index(i)] * points[i].in_image.homogeneous());
  }
  if (!open->is_plane && is_mirrored(in_world, in_camera)) return std::nullopt;
  const auto similarity = align(in_world, in_camera);
  if (!similarity || !(similarity->scale > 0)) return std::nullopt;
  LinearPose pose;
  pose.cam_from_world = {similarity->rotation, similarity->translation / similarity->scale};
  pose.is_plane = open->is_plane;
  pose.redundancy = 2 * static_cast<int>(points.size()) - 6;
  for (const Vector3d& point : in_world)
    if (!((pose.cam_from_world * point).z() > 0)) return std::nullopt;
  const std::vector<ByPixel> by_pixel = derivatives_of_pose(points, *depths, *similarity);
  for (std::size_t i = 0; i < points.size(); ++i)
    pose.covariance += points[i].sigma * points[i].sigma * by_pixel[i] * by_pixel[i].transpose();
  add_residuals(points, by_pixel, pose);
  return pose;
}

}  // namespace collinea
