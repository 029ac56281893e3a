// SPDX-License-Identifier: Apache-2.0
#include "dense.h"

#include <Eigen/Cholesky>
#include <set>

#include "collinea/geometry/rotation.h"

namespace collinea::bench {
namespace {

double weak_weight(const Camera& camera, int param) {
  const auto squared = [](double x) { return 1 / (x * x); };
  if (param == Camera::kF) return squared(camera.prior.sigma_f_px);
  if (param == Camera::kCx || param == Camera::kCy) return squared(0.03 * camera.width_px);
  if (param == Camera::kK1) return squared(0.2);
  if (param == Camera::kK2 || param == Camera::kK3) return squared(0.5);
  if (param == Camera::kP1 || param == Camera::kP2) return squared(0.01);
  return squared(0.005 * camera.focal_px());
}

}  // namespace

DenseNormals dense_normals(const Block& block, const Examined& adjusted, const AdjustScope& scope,
                           const std::vector<int>& free) {
  DenseNormals normals;
  normals.free = free;
  int size = 0;
  const auto assign = [&](auto& map, auto id, int rows) {
    map[id] = size;
    size += rows;
  };
  for (const auto& [id, pose] : adjusted.cam_from_world) assign(normals.image, id, 6);
  for (const auto& [id, camera] : adjusted.cameras) assign(normals.camera, id, static_cast<int>(free.size()));
  for (const auto& [id, position] : adjusted.points) assign(normals.point, id, 3);
  for (const ControlDifference& control : adjusted.control)
    if (control.used) assign(normals.control, control.point, 3);
  normals.matrix.setZero(size, size);
  const auto add = [&](ImageId image, int point, const Eigen::Vector3d& at, double sigma_px) {
    const Rigid3& pose = adjusted.cam_from_world.at(image);
    const CameraId its = block.images.at(image).camera;
    const auto calibrated = adjusted.cameras.find(its);
    const Camera& camera = calibrated == adjusted.cameras.end() ? block.cameras.at(its) : calibrated->second;
    Matrix23 by_cam;
    Matrix2P by_params;
    if (!project(camera, pose * at, &by_cam, &by_params)) return;
    const Eigen::Matrix3d rotation = pose.rotation.toRotationMatrix();
    DenseMatrix row(2, 9 + static_cast<int>(free.size()));
    row.leftCols(3) = (-by_cam * rotation * skew(at - centre_of(pose))).cast<long double>();
    row.middleCols(3, 3) = (-by_cam * rotation).cast<long double>();
    row.middleCols(6, 3) = (by_cam * rotation).cast<long double>();
    for (std::size_t k = 0; k < free.size(); ++k)
      row.col(9 + static_cast<int>(k)) = by_params.col(free[k]).cast<long double>();
    row /= sigma_px;
    std::vector<int> columns;
    for (int k = 0; k < 6; ++k) columns.push_back(normals.image.at(image) + k);
    for (int k = 0; k < 3; ++k) columns.push_back(point + k);
    if (calibrated != adjusted.cameras.end())
      for (std::size_t k = 0; k < free.size(); ++k) columns.push_back(normals.camera.at(its) + static_cast<int>(k));
    for (std::size_t a = 0; a < columns.size(); ++a)
      for (std::size_t b = 0; b < columns.size(); ++b)
        normals.matrix(columns[a], columns[b]) += row.col(static_cast<int>(a)).dot(row.col(static_cast<int>(b)));
  };
  std::map<PointId, Eigen::Vector3d> at;
  for (const auto& [id, position] : adjusted.points) at[id] = position;
  for (const std::uint32_t i : adjusted.observations) {
    const Observation& seen = block.observations[i];
    add(seen.image, normals.point.at(seen.point), at.at(seen.point), seen.sigma_px);
  }
  for (const ControlDifference& control : adjusted.control) {
    if (!control.used) continue;
    const int row = normals.control.at(control.point);
    for (const ControlObservation& seen : block.control_observations)
      if (seen.point == control.point) add(seen.image, row, *control.position_in_world, seen.sigma_px);
    for (int k = 0; k < 3; ++k)
      normals.matrix(row + k, row + k) += std::pow(block.control.at(control.point).sigma_m[k], -2);
  }
  for (const PositionDifference& position : adjusted.positions)
    for (int k = 0; k < 3; ++k) {
      const int row = normals.image.at(position.image) + 3 + k;
      normals.matrix(row, row) += std::pow(block.images.at(position.image).position->sigma_m[k], -2);
    }
  for (const auto& [id, row] : normals.camera) {
    const auto first = scope.first_cameras.find(id);
    const Camera& given = first == scope.first_cameras.end() ? block.cameras.at(id) : first->second;
    for (std::size_t k = 0; k < free.size(); ++k)
      normals.matrix(row + static_cast<int>(k), row + static_cast<int>(k)) += weak_weight(given, free[k]);
  }
  return normals;
}

DenseMatrix inverse_of(const DenseMatrix& matrix) {
  const Eigen::Matrix<long double, Eigen::Dynamic, 1> scale = matrix.diagonal().cwiseSqrt().cwiseInverse();
  const DenseMatrix scaled = scale.asDiagonal() * matrix * scale.asDiagonal();
  const DenseMatrix inverse = scaled.llt().solve(DenseMatrix::Identity(matrix.rows(), matrix.cols()));
  return scale.asDiagonal() * inverse * scale.asDiagonal();
}

}  // namespace collinea::bench
