// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Core>
#include <algorithm>

#include "collinea/adjust/control_prediction.h"
#include "collinea/adjust/free_network.h"
#include "collinea/adjust/normals.h"
#include "collinea/adjust/outcome.h"
#include "collinea/adjust/point_cofactor.h"
#include "collinea/adjust/weakness.h"
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

Eigen::MatrixXd block_of(TileCholesky& inverse, int row, int rows, int column, int columns) {
  Eigen::MatrixXd block(rows, columns);
  for (int c = 0; c < columns; ++c)
    for (int r = 0; r < rows; ++r)
      block(r, c) = inverse.at(std::max(row + r, column + c), std::min(row + r, column + c));
  return block;
}

}  // namespace

void add_covariances(const Block& block, const Problem& problem, const State& state, const AdjustOptions& options,
                     const Run& run, Normals& normals, Adjusted& adjusted) {
  WeaknessFinder weaknesses(block, problem, state, adjusted);
  weaknesses.look_at_observations();
  normals.accumulate(state, 0, run, kDatumStiffness);
  int failed_row = -1;
  std::optional<TileCholesky> factor = normals.factor(run, kLeastPivot, failed_row);
  if (run.stopped()) return;
  if (!factor) {
    adjusted.undetermined = name_of_unknown(block, problem, failed_row) + " is not determined by the observations";
    weaknesses.look_at_loose_images(run, normals);
    return;
  }
  TileCholesky& matrix = *factor;
  weaknesses.look_at_correlations(matrix);
  const FreeNetwork free_network(problem, state, matrix);
  predict_check_points(block, problem, state, matrix, run, adjusted);
  matrix.invert(run);
  if (run.stopped()) return;
  predict_control_points(problem, state, matrix, adjusted);
  for (int i = 0; i < problem.poses; ++i) {
    Matrix6d to_world = Matrix6d::Identity();
    to_world.topLeftCorner<3, 3>() = state.rotations[i].conjugate().toRotationMatrix();
    adjusted.pose_covariance[problem.images[i].id] =
        free_network.of_pose(to_world * block_of(matrix, 6 * i, 6, 6 * i, 6) * to_world.transpose(), i, to_world);
  }
  weaknesses.look_at_images();
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
  if (options.reliability) add_reliability(block, problem, state, options, matrix, run, adjusted);
  if (!options.point_covariances || run.stopped()) return;
  std::map<PointId, std::size_t> place;
  for (std::size_t i = 0; i < adjusted.points.size(); ++i) place[adjusted.points[i].first] = i;
  adjusted.point_covariance.resize(adjusted.points.size());
  parallel_for(run, problem.point_count(), [&](std::size_t p) {
    if (problem.point(p).held || problem.point(p).control >= 0) return;
    adjusted.point_covariance[place.at(PointId{problem.point(p).id})] =
        free_network.of_point(PointSystem(problem, state, p).covariance(matrix), p);
  });
}

}  // namespace collinea::bundle
