// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Cholesky>
#include <algorithm>

#include "collinea/adjust/conditioning.h"
#include "collinea/adjust/control_folds.h"
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
  if (extra.kind == UnknownKind::kTimeOffset)
    return "fly strips in the opposite direction under one shift, or give one of them";
  if (is_of_shape(extra.kind)) return "give control, or points that are further apart";
  if (is_along_axis(extra) || (other && is_along_axis(*other)))
    return "add strips at another height or oblique images, or give one of them";
  if (extra.kind == UnknownKind::kOrientation) return "measure to more points from there";
  if (extra.kind == UnknownKind::kLeverArm || (other && other->kind == UnknownKind::kLeverArm) ||
      extra.kind == UnknownKind::kBoresight)
    return "add strips in the opposite direction and across, or give one of them";
  return "add cross strips, or control in every strip";
}

// What name_inseparable_offsets() says, and what only follows from it: axes of one shift that an offset ties together.
bool parted_elsewhere(const ExtraUnknown& one, const ExtraUnknown& other, bool offsets) {
  if (one.kind == UnknownKind::kTimeOffset) return true;
  return offsets && one.kind == other.kind && one.owner == other.owner;
}

void name_inseparable(const Block& block, const Problem& problem, TileCholesky& inverse, Adjusted& adjusted) {
  const int border = 6 * problem.poses;
  const bool offsets = !adjusted.inseparable.empty();
  for (int i = 0; i < static_cast<int>(problem.extras.size()); ++i) {
    const int row = border + problem.first_extra + i;
    const ExtraUnknown& extra = problem.extras[static_cast<std::size_t>(i)];
    for (int other = border; other < row; ++other) {
      const int k = other - border - problem.first_extra;
      if (k >= 0 && parted_elsewhere(extra, problem.extras[static_cast<std::size_t>(k)], offsets)) continue;
      const double correlation = inverse.at(row, other) / std::sqrt(inverse.at(row, row) * inverse.at(other, other));
      if (!(std::abs(correlation) > kInseparable)) continue;
      adjusted.inseparable.push_back(
          name_of_unknown(block, problem, row) + " and " + name_of_unknown(block, problem, other) +
          " can hardly be separated (correlation " + std::to_string(correlation).substr(0, correlation < 0 ? 6 : 5) +
          "): " + cure_of(extra, k < 0 ? nullptr : &problem.extras[static_cast<std::size_t>(k)]));
    }
  }
}

// A time offset moves the antenna along the flight, which need not be an axis: what of it a shift, a drift or a lever
// arm can stand for is its multiple correlation with the three.
void name_inseparable_offsets(const Block& block, const Problem& problem, TileCholesky& inverse, Adjusted& adjusted) {
  const int first = 6 * problem.poses + problem.first_extra;
  for (std::size_t i = 0; i < problem.extras.size(); ++i) {
    if (problem.extras[i].kind != UnknownKind::kTimeOffset) continue;
    const int row = first + static_cast<int>(i);
    for (std::size_t k = 0; k < problem.extras.size(); ++k) {
      const ExtraUnknown& other = problem.extras[k];
      const bool moves_antennas = other.kind == UnknownKind::kShift || other.kind == UnknownKind::kDrift ||
                                  other.kind == UnknownKind::kLeverArm;
      if (!moves_antennas || other.axis != 0) continue;
      const int three = first + static_cast<int>(k);
      const Eigen::Matrix3d own = block_of(inverse, three, 3, three, 3);
      const Eigen::Vector3d with = block_of(inverse, three, 3, row, 1);
      const Eigen::Vector3d scale = own.diagonal().cwiseSqrt().cwiseInverse();
      const Eigen::Matrix3d correlations = scale.asDiagonal() * own * scale.asDiagonal();
      const Eigen::Vector3d coupling = scale.asDiagonal() * with / std::sqrt(inverse.at(row, row));
      const double square = coupling.dot(correlations.ldlt().solve(coupling));
      if (!(square > kInseparable * kInseparable)) continue;
      std::string name = name_of_extra(block, other.kind, other.owner, 0);
      const std::size_t axis = name.find(other.kind == UnknownKind::kLeverArm ? " to the right" : " in east");
      name.replace(axis, other.kind == UnknownKind::kLeverArm ? 13 : 8, " along the flight");
      adjusted.inseparable.push_back(
          name_of_unknown(block, problem, row) + " and " + name + " can hardly be separated (correlation " +
          std::to_string(std::sqrt(square)).substr(0, 5) + "): " + cure_of(problem.extras[i], &other));
    }
  }
}

// Standard deviations of unknowns beside images, cameras and points, and of what was measured on the ground.
void predict_others(const Problem& problem, const State& state, TileCholesky& inverse, const FreeNetwork& free_network,
                    Adjusted& adjusted) {
  const int border = 6 * problem.poses;
  for (std::size_t i = 0; i < problem.extras.size(); ++i) {
    const int row = border + problem.first_extra + static_cast<int>(i);
    adjusted.extras[i].sigma = std::sqrt(inverse.at(row, row));
  }
  for (std::size_t i = 0; i < problem.ground.size(); ++i) {
    const GroundLink& link = problem.ground[i];
    GroundDifference& difference = adjusted.ground[i];
    const GroundModel model = model_of(problem, link, state);
    const Row row = row_of(problem, link, model);
    const double variance = free_network.of_link(variance_of(row, inverse), link, model, row);
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
    const auto extra = static_cast<std::size_t>(failed_row - 6 * problem.poses - problem.first_extra);
    if (extra < problem.extras.size())
      adjusted.undetermined += std::string(": ") + cure_of(problem.extras[extra], nullptr);
    weaknesses.look_at_bases(nullptr, run);
    weaknesses.look_at_loose_images(run, normals);
    return;
  }
  TileCholesky& matrix = *factor;
  adjusted.conditioning = conditioning_of(block, problem, normals.diagonal(), matrix, run);
  weaknesses.look_at_correlations(matrix);
  const FreeNetwork free_network(problem, state, matrix);
  predict_check_points(block, problem, state, matrix, free_network, run, adjusted);
  std::optional<ControlFolds> folds;
  if (options.reliability) folds.emplace(problem, state, matrix, run);
  if (run.stopped()) return;
  matrix.invert(run);
  if (run.stopped()) return;
  predict_control_points(block, problem, state, matrix, free_network, adjusted);
  predict_others(problem, state, matrix, free_network, adjusted);
  name_inseparable_offsets(block, problem, matrix, adjusted);
  name_inseparable(block, problem, matrix, adjusted);
  for (int i = 0; i < problem.poses; ++i) {
    Matrix6d to_world = Matrix6d::Identity();
    to_world.topLeftCorner<3, 3>() = state.rotations[i].conjugate().toRotationMatrix();
    adjusted.pose_covariance[problem.images[i].id] =
        free_network.of_pose(to_world * block_of(matrix, 6 * i, 6, 6 * i, 6) * to_world.transpose(), i, to_world);
  }
  weaknesses.look_at_bases(&matrix, run);
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
  add_places(problem, state, free_network, matrix, run, adjusted);
  correlate_cameras_and_poses(problem, state, matrix, adjusted);
  if (options.reliability) add_reliability(block, problem, state, options, matrix, run, adjusted);
  if (adjusted.reliability)
    adjusted.reliability->folded = folds->leave_out(problem, state, adjusted, options.tests.folds);
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
