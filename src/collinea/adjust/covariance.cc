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
      return param_name(camera.free[k]) + " of camera " + block.cameras.at(camera.id).name;
  const int in_border = row - 6 * problem.poses;
  if (const auto k = static_cast<std::size_t>(in_border - problem.first_extra); k < problem.extras.size())
    return name_of_extra(block, problem.extras[k].kind, problem.extras[k].owner, problem.extras[k].axis);
  for (const std::uint32_t p : problem.joined)
    if (const int k = in_border - problem.point(p).joined; k >= 0 && k < 3)
      return "the position of " + block.control.at(ControlId{problem.point(p).id}).name;
  return "an unknown";
}

Eigen::MatrixXd block_of(TileCholesky& inverse, int row, int rows, int column, int columns) {
  Eigen::MatrixXd block(rows, columns);
  for (int c = 0; c < columns; ++c)
    for (int r = 0; r < rows; ++r)
      block(r, c) = inverse.at(std::max(row + r, column + c), std::min(row + r, column + c));
  return block;
}

constexpr double kInseparable = 0.99;  // correlation: the sigma of each is seven times what it were without the other

bool is_along_axis(const ExtraUnknown& extra) { return extra.kind == UnknownKind::kLeverArm && extra.axis == 2; }

// What would part an unknown from another one, or (other = nullptr) from a parameter of a camera.
const char* cure_of(const ExtraUnknown& extra, const ExtraUnknown* other) {
  if (is_along_axis(extra) || (other && is_along_axis(*other)))
    return "add strips at another height or oblique images, or give one of them";
  if (extra.kind == UnknownKind::kOrientation) return "measure to more points from there";
  if (extra.kind == UnknownKind::kLeverArm || (other && other->kind == UnknownKind::kLeverArm) ||
      extra.kind == UnknownKind::kBoresight)
    return "add strips in the opposite direction and across, or give one of them";
  return "add cross strips, or control in every strip";
}

void name_inseparable(const Block& block, const Problem& problem, TileCholesky& inverse, Adjusted& adjusted) {
  const int border = 6 * problem.poses;
  for (int i = 0; i < static_cast<int>(problem.extras.size()); ++i) {
    const int row = border + problem.first_extra + i;
    const ExtraUnknown& extra = problem.extras[static_cast<std::size_t>(i)];
    for (int other = border; other < row; ++other) {
      const double correlation = inverse.at(row, other) / std::sqrt(inverse.at(row, row) * inverse.at(other, other));
      if (!(std::abs(correlation) > kInseparable)) continue;
      const int k = other - border - problem.first_extra;
      adjusted.inseparable.push_back(
          name_of_unknown(block, problem, row) + " and " + name_of_unknown(block, problem, other) +
          " can hardly be separated (correlation " + std::to_string(correlation).substr(0, correlation < 0 ? 6 : 5) +
          "): " + cure_of(extra, k < 0 ? nullptr : &problem.extras[static_cast<std::size_t>(k)]));
    }
  }
}

// Standard deviations of unknowns beside images, cameras and points, and of what was measured on the ground.
void predict_others(const Problem& problem, const State& state, TileCholesky& inverse, Adjusted& adjusted) {
  const int border = 6 * problem.poses;
  for (std::size_t i = 0; i < problem.extras.size(); ++i) {
    const int row = border + problem.first_extra + static_cast<int>(i);
    adjusted.extras[i].sigma = std::sqrt(inverse.at(row, row));
  }
  for (std::size_t i = 0; i < problem.ground.size(); ++i) {
    const GroundLink& link = problem.ground[i];
    GroundDifference& difference = adjusted.ground[i];
    const double variance = variance_of(row_of(problem, link, model_of(problem, link, state)), inverse);
    const double sigma = link.observation.sigma, scaled = std::pow(sigma_scale(adjusted), 2) * variance;
    difference.sigma = std::sqrt(std::max(variance, 0.0));
    // Of a residual it is what is left of the sigma; see predict_control_points.
    const double h = variance / (sigma * sigma);
    difference.difference_sigma =
        std::sqrt(std::max(0.0, difference.used ? scaled * (1 - h) + sigma * sigma - 2 * variance + h * variance
                                                : scaled + sigma * sigma));
  }
}

}  // namespace

double variance_of(const Row& row, TileCholesky& inverse) {
  double sum = 0;
  for (const RowPart& a : row)
    for (const RowPart& b : row)
      sum += a.derivative * b.derivative * inverse.at(std::max(a.row, b.row), std::min(a.row, b.row));
  return sum;
}

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
  predict_control_points(block, problem, state, matrix, adjusted);
  predict_others(problem, state, matrix, adjusted);
  name_inseparable(block, problem, matrix, adjusted);
  for (int i = 0; i < problem.poses; ++i) {
    Matrix6d to_world = Matrix6d::Identity();
    to_world.topLeftCorner<3, 3>() = state.rotations[i].conjugate().toRotationMatrix();
    adjusted.pose_covariance[problem.images[i].id] =
        free_network.of_pose(to_world * block_of(matrix, 6 * i, 6, 6 * i, 6) * to_world.transpose(), i, to_world);
  }
  weaknesses.look_at_images();
  for (const ProblemCamera& camera : problem.cameras) {
    if (camera.free.empty()) continue;
    const int size = Camera::kParams + static_cast<int>(count_of(block.cameras.at(camera.id).additional));
    MatrixPd covariance = MatrixPd::Zero(size, size);
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
