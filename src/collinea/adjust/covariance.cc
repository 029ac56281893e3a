// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Core>
#include <algorithm>

#include "collinea/adjust/normals.h"
#include "collinea/adjust/outcome.h"
#include "collinea/base/parallel.h"

namespace collinea::bundle {
namespace {

constexpr double kDatumStiffness = 1e6;  // the datum constraints count as exact
constexpr double kLeastPivot = 1e-13;    // of its diagonal element: rounding leaves no more

std::string name_of_unknown(const Block& block, const Problem& problem, int row) {
  if (row < 6 * problem.poses)
    return (row % 6 < 3 ? "the attitude of " : "the position of ") + block.images.at(problem.images[row / 6].id).file;
  for (const ProblemCamera& camera : problem.cameras)
    if (const int k = row - 6 * problem.poses - camera.border; k >= 0 && k < static_cast<int>(camera.free.size()))
      return std::string(Camera::kParamNames[camera.free[k]]) + " of camera " + block.cameras.at(camera.id).name;
  return "an unknown";
}

// One group of unknowns that a point depends on: where it begins, and Z = W L^-T.
struct Dependence {
  int row;
  Eigen::Matrix<double, Eigen::Dynamic, 3, 0, Camera::kParams, 3> z;
};

Eigen::MatrixXd block_of(TileCholesky& inverse, int row, int rows, int column, int columns) {
  Eigen::MatrixXd block(rows, columns);
  for (int c = 0; c < columns; ++c)
    for (int r = 0; r < rows; ++r)
      block(r, c) = inverse.at(std::max(row + r, column + c), std::min(row + r, column + c));
  return block;
}

// L^-T (I + Z^T S^-1 Z) L^-1
Eigen::Matrix3d point_covariance(const Problem& problem, const State& state, std::size_t p, TileCholesky& inverse) {
  const ProblemPoint& point = problem.point(p);
  PointNormals normals;
  std::vector<Dependence> dependences;
  std::map<int, Dependence> cameras;
  for (std::uint32_t r = point.first_ray; r < problem.end_ray(p); ++r) {
    const Ray& ray = problem.rays[r];
    const int camera = problem.images[ray.image].camera;
    LinearRay linear;
    linearise(ray, state.frames[ray.image], state.lenses[camera], &state.points[3 * p], problem.loss_of(point),
              &linear);
    normals.add(linear);
    const Eigen::Map<const Eigen::Matrix<double, 2, 3, Eigen::RowMajor>> a(linear.by_point), turn(linear.by_rotation);
    if (static_cast<int>(ray.image) < problem.poses) {
      Dependence pose{6 * static_cast<int>(ray.image), {}};
      pose.z.resize(6, 3);
      pose.z << turn.transpose() * a, -a.transpose() * a;
      dependences.push_back(pose);
    }
    const ProblemCamera& unknowns = problem.cameras[camera];
    if (unknowns.free.empty()) continue;
    const auto count = static_cast<Eigen::Index>(unknowns.free.size());
    double b[2 * Camera::kParams];
    linearise_camera(linear, state.lenses[camera], unknowns.free, b);
    const auto [its, is_new] = cameras.try_emplace(camera, Dependence{6 * problem.poses + unknowns.border, {}});
    if (is_new) its->second.z.setZero(count, 3);
    const Eigen::Map<const Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::RowMajor>> by_camera(b, 2, count);
    its->second.z += by_camera.transpose() * a;
  }
  for (const auto& [camera, dependence] : cameras) dependences.push_back(dependence);
  normals.factor(0);
  for (Dependence& dependence : dependences)
    for (Eigen::Index i = 0; i < dependence.z.rows(); ++i) {
      Eigen::Vector3d row = dependence.z.row(i);
      normals.forward(row.data());
      dependence.z.row(i) = row;
    }
  Eigen::Matrix3d middle = Eigen::Matrix3d::Identity();
  for (const Dependence& one : dependences)
    for (const Dependence& other : dependences)
      middle +=
          one.z.transpose() * block_of(inverse, one.row, int(one.z.rows()), other.row, int(other.z.rows())) * other.z;
  for (int pass = 0; pass < 2; ++pass) {
    for (int c = 0; c < 3; ++c) normals.backward(middle.col(c).data());
    middle.transposeInPlace();
  }
  return middle;
}

}  // namespace

void add_covariances(const Block& block, const Problem& problem, const State& state, bool of_points, const Run& run,
                     Adjusted& adjusted) {
  Normals normals(problem);
  normals.accumulate(state, 0, run, kDatumStiffness);
  TileCholesky& matrix = normals.matrix();
  if (!matrix.factor(run, kLeastPivot)) {
    adjusted.undetermined =
        name_of_unknown(block, problem, matrix.failed_row()) + " is not determined by the observations";
    return;
  }
  if (run.stopped()) return;
  matrix.invert(run);
  if (run.stopped()) return;
  for (int i = 0; i < problem.poses; ++i) {
    Matrix6d to_world = Matrix6d::Identity();
    to_world.topLeftCorner<3, 3>() = state.rotations[i].conjugate().toRotationMatrix();
    adjusted.pose_covariance[problem.images[i].id] =
        to_world * block_of(matrix, 6 * i, 6, 6 * i, 6) * to_world.transpose();
  }
  for (const ProblemCamera& camera : problem.cameras) {
    if (camera.free.empty()) continue;
    MatrixPd covariance = MatrixPd::Zero();
    const int first = 6 * problem.poses + camera.border;
    for (std::size_t a = 0; a < camera.free.size(); ++a)
      for (std::size_t b = 0; b < camera.free.size(); ++b) {
        const int i = first + static_cast<int>(a), k = first + static_cast<int>(b);
        covariance(camera.free[a], camera.free[b]) = matrix.at(std::max(i, k), std::min(i, k));
      }
    adjusted.camera_covariance[camera.id] = covariance;
  }
  if (!of_points) return;
  std::map<PointId, std::size_t> place;
  for (std::size_t i = 0; i < adjusted.points.size(); ++i) place[adjusted.points[i].first] = i;
  adjusted.point_covariance.resize(adjusted.points.size());
  parallel_for(run, problem.point_count(), [&](std::size_t p) {
    if (problem.point(p).held || problem.point(p).control >= 0) return;
    adjusted.point_covariance[place.at(PointId{problem.point(p).id})] = point_covariance(problem, state, p, matrix);
  });
}

}  // namespace collinea::bundle
