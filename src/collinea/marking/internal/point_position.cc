// SPDX-License-Identifier: Apache-2.0
#include "collinea/marking/internal/point_position.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "collinea/block/survey_covariance.h"
#include "collinea/epipolar/intersect.h"
#include "collinea/epipolar/intersect_rays.h"
#include "collinea/math/median.h"

namespace collinea {
namespace {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

// Chi-squared with 1, 2 and 3 degrees of freedom, exceeded with a probability of 0.1 %.
constexpr double kLimit[] = {10.828, 13.816, 16.266};

/// What is known of a position before it is marked.
struct Prior {
  Vector3d position = Vector3d::Zero();
  Matrix3d information = Matrix3d::Zero();
};

// The smallest variance of given coordinates: points that are fixed have none.
constexpr double kLeastVariance_m2 = 1e-8;

// The given coordinates on the axes that have some; a missing height is that of the tie points.
std::optional<Prior> given_prior(const MarkingBlock& in, const ControlPoint& given) {
  Prior prior{given.position_in_world};
  const bool has_plan = given.sigma_m.head<2>().allFinite() && given.position_in_world.head<2>().allFinite();
  if (!has_plan) return std::nullopt;
  const bool has_height = std::isfinite(given.sigma_m.z()) && std::isfinite(given.position_in_world.z());
  Matrix3d covariance = survey_covariance(given.sigma_m, given.correlation) + kLeastVariance_m2 * Matrix3d::Identity();
  if (!has_height) {
    std::vector<double> heights;
    for (const auto& [id, point] : in.block.points) heights.push_back(point.position_in_world.z());
    if (heights.empty()) return std::nullopt;
    prior.position.z() = median(heights);
    for (double& height : heights) height = std::abs(height - prior.position.z());
    const double spread = std::max(1.0, quantile(heights, 0.9));
    covariance.col(2).setZero();
    covariance.row(2).setZero();
    covariance(2, 2) = spread * spread;
  }
  const Eigen::LLT<Matrix3d> factor(covariance);
  if (factor.info() != Eigen::Success) return std::nullopt;
  prior.information = factor.solve(Matrix3d::Identity());
  return prior;
}

// Along the ray of a mark, at the depth of the tie points nearest to it in the image.
std::optional<Prior> ground_prior(const MarkingBlock& in, const ControlObservation& mark) {
  constexpr std::size_t kNearest = 12;
  constexpr double kLeastSpread = 0.01;  // of the depth: the ground between tie points
  const auto found = in.observations.find(mark.image);
  if (found == in.observations.end() || found->second.size() < kNearest) return std::nullopt;
  const Rigid3 pose = pose_of(in.block, mark.image);
  const Camera& camera = in.block.camera_of(mark.image);
  std::vector<std::pair<double, double>> near;  // squared distance in the image, distance from the camera
  for (const std::size_t o : found->second) {
    const Observation& seen = in.block.observations[o];
    const auto point = in.block.points.find(seen.point);
    if (point == in.block.points.end()) continue;
    near.emplace_back((seen.pixel - mark.pixel).squaredNorm(), (pose * point->second.position_in_world).norm());
  }
  if (near.size() < kNearest) return std::nullopt;
  std::nth_element(near.begin(), near.begin() + kNearest - 1, near.end());
  std::vector<double> distances;
  for (std::size_t i = 0; i < kNearest; ++i) distances.push_back(near[i].second);
  const double distance = median(distances);
  for (double& one : distances) one = std::abs(one - distance);
  const double sigma = std::max(kLeastSpread * distance, 1.5 * median(distances));
  const Vector3d ray = pose.rotation.conjugate() * ray_in_cam(camera, mark.pixel);
  return Prior{centre_of(pose) + distance * ray, ray * ray.transpose() / (sigma * sigma)};
}

/// Normal equations of position and poses.
std::optional<PointState> adjusted(const Block& block, const LocalPoses& local, std::span<const PointMark> marks,
                                   const Prior& prior, const Vector3d& start) {
  const Eigen::Index size = 3 + local.information.cols();
  PointState state{.position_in_world = start, .pose_steps = VectorXd::Zero(size - 3)};
  for (int iteration = 0; iteration < 20; ++iteration) {
    MatrixXd normal = MatrixXd::Zero(size, size);
    VectorXd right = VectorXd::Zero(size);
    normal.topLeftCorner<3, 3>() = prior.information;
    right.head<3>() = prior.information * (prior.position - state.position_in_world);
    normal.bottomRightCorner(size - 3, size - 3) = local.information;
    right.tail(size - 3) = -local.information * state.pose_steps;
    for (const PointMark& mark : marks) {
      const Eigen::Index at = 3 + 6 * Eigen::Index(mark.image);
      const auto linear = linear_pixel(block.camera_of(local.images[mark.image]), local.cam_from_world[mark.image],
                                       state.position_in_world);
      if (!linear) return std::nullopt;
      const Matrix2d weight = mark.covariance.inverse();
      const Vector2d misfit =
          mark.pixel - linear->pixel - linear->by_pose * state.pose_steps.segment<6>(6 * Eigen::Index(mark.image));
      const Eigen::Matrix<double, 2, 3> a = linear->by_point;
      const Eigen::Matrix<double, 2, 6> b = linear->by_pose;
      normal.topLeftCorner<3, 3>() += a.transpose() * weight * a;
      normal.block<3, 6>(0, at) += a.transpose() * weight * b;
      normal.block<6, 3>(at, 0) += b.transpose() * weight * a;
      normal.block<6, 6>(at, at) += b.transpose() * weight * b;
      right.head<3>() += a.transpose() * weight * misfit;
      right.segment<6>(at) += b.transpose() * weight * misfit;
    }
    const Eigen::LLT<MatrixXd> factor(normal);
    if (factor.info() != Eigen::Success) return std::nullopt;
    const VectorXd step = factor.solve(right);
    if (!step.allFinite()) return std::nullopt;
    state.position_in_world += step.head<3>();
    state.pose_steps += step.tail(size - 3);
    if (step.dot(normal * step) > 1e-8 && iteration < 19) continue;  // a ten-thousandth of a standard deviation
    state.covariance = factor.solve(MatrixXd::Identity(size, size));
    return state;
  }
  return std::nullopt;
}

// Whether a prior misses a state that was found without it by more than chance makes it, on the axes that it has.
bool disagrees(const Prior& prior, const Vector3d& position, const Matrix3d& covariance) {
  const Vector3d difference = position - prior.position;
  // I = L L': the prior's own unit axes; those without information say nothing.
  const Eigen::LDLT<Matrix3d> factor(prior.information);
  const Matrix3d of_prior = factor.solve(Matrix3d::Identity());
  const double squared = difference.dot((covariance + of_prior).ldlt().solve(difference));
  return !(squared < kLimit[2]);
}

bool misses(const Block& block, const LocalPoses& local, const PointState& state, const PointMark& mark) {
  const auto linear = linear_pixel(block.camera_of(local.images[mark.image]), local.cam_from_world[mark.image],
                                   state.position_in_world);
  if (!linear) return true;
  MatrixXd rows = MatrixXd::Zero(2, state.covariance.cols());
  rows.leftCols<3>() = linear->by_point;
  rows.middleCols<6>(3 + 6 * Eigen::Index(mark.image)) = linear->by_pose;
  const Matrix2d covariance = rows * state.covariance * rows.transpose() + mark.covariance;
  const Vector2d misfit = mark.pixel - linear->pixel;
  return !(misfit.dot(covariance.inverse() * misfit) < kLimit[1]);
}

std::optional<Vector3d> intersection_of(const Block& block, const std::vector<ControlObservation>& marks) {
  std::vector<SightLine> lines;
  for (const ControlObservation& mark : marks)
    lines.push_back({&block.camera_of(mark.image), pose_of(block, mark.image), mark.pixel, mark.sigma_px, mark.shape});
  const auto found = intersect(lines);
  return found ? std::optional(found->point_in_world) : std::nullopt;
}

}  // namespace

std::vector<PointMark> point_marks(const LocalPoses& local, const std::vector<ControlObservation>& marks) {
  std::vector<PointMark> all;
  for (const ControlObservation& mark : marks) {
    const auto found = std::find(local.images.begin(), local.images.end(), mark.image);
    if (found == local.images.end()) continue;
    all.push_back({std::size_t(found - local.images.begin()), mark.pixel,
                   mark.sigma_px * mark.sigma_px * mark.shape.covariance()});
  }
  return all;
}

std::vector<ControlObservation> agreeing_marks(const Block& block, const std::vector<ControlObservation>& marks) {
  std::vector<ControlObservation> oriented;
  for (const ControlObservation& mark : marks)
    if (is_oriented(block, mark.image) && mark.sigma_px > 0 && mark.pixel.allFinite()) oriented.push_back(mark);
  if (oriented.size() < 3) return oriented;
  std::vector<Rigid3> poses;
  std::vector<Vector2d> normalized_xy;
  std::vector<double> focal_px;
  double limit_px = kAgree_px;
  for (const ControlObservation& mark : oriented) {
    const Camera& camera = block.camera_of(mark.image);
    poses.push_back(pose_of(block, mark.image));
    normalized_xy.push_back(normalized(camera, mark.pixel));
    focal_px.push_back(camera.focal_px());
    limit_px = std::max(limit_px, 6 * mark.sigma_px);
  }
  const auto found = robust_intersect(poses, normalized_xy, focal_px, limit_px);
  if (!found) return oriented;
  std::vector<ControlObservation> agreeing;
  for (std::size_t i = 0; i < oriented.size(); ++i)
    if (found->inlier[i]) agreeing.push_back(oriented[i]);
  return agreeing;
}

std::optional<Vector3d> start_position(const MarkingBlock& in, const ControlPoint& given,
                                       const std::vector<ControlObservation>& marks) {
  if (marks.size() >= 2)
    if (const auto position = intersection_of(in.block, marks)) return position;
  if (const auto prior = given_prior(in, given)) return prior->position;
  if (marks.empty()) return std::nullopt;
  const auto prior = ground_prior(in, marks.front());
  return prior ? std::optional(prior->position) : std::nullopt;
}

std::optional<PointState> state_of_point(const MarkingBlock& in, const LocalPoses& local, const ControlPoint& given,
                                         const std::vector<ControlObservation>& marks) {
  const std::vector<PointMark> seen = point_marks(local, marks);
  const auto prior = given_prior(in, given);
  std::optional<Vector3d> met;
  if (marks.size() >= 2) met = intersection_of(in.block, marks);
  if (met) {
    auto alone = adjusted(in.block, local, seen, {}, *met);
    if (alone && prior && !disagrees(*prior, alone->position_in_world, alone->covariance.topLeftCorner<3, 3>()))
      return adjusted(in.block, local, seen, *prior, alone->position_in_world);
    if (alone) {
      alone->given_disagrees = prior.has_value();
      return alone;
    }
  }
  if (prior) {
    const auto unmarked = adjusted(in.block, local, {}, *prior, prior->position);
    std::vector<PointMark> hits;
    for (const PointMark& mark : seen)
      if (unmarked && !misses(in.block, local, *unmarked, mark)) hits.push_back(mark);
    if (unmarked && seen.empty()) return unmarked;
    if (!hits.empty()) return adjusted(in.block, local, hits, *prior, prior->position);
  }
  if (marks.empty()) return std::nullopt;
  const auto ground = ground_prior(in, marks.front());
  if (!ground) return std::nullopt;
  auto state = adjusted(in.block, local, std::span(seen).first(1), *ground, ground->position);
  if (state) state->given_disagrees = prior.has_value();
  return state;
}

PointState state_of_marks(const Block& block, const LocalPoses& local, const std::vector<ControlObservation>& marks,
                          const Vector3d& position_in_world) {
  double distance = 0;
  for (const Rigid3& pose : local.cam_from_world)
    distance = std::max(distance, (centre_of(pose) - position_in_world).norm());
  const Prior loose{position_in_world, Matrix3d::Identity() / (100 * distance * distance)};
  // One step from where the point lies: only the covariance is asked for.
  std::vector<PointMark> seen = point_marks(local, marks);
  for (PointMark& mark : seen)
    if (const auto linear = linear_pixel(block.camera_of(local.images[mark.image]), local.cam_from_world[mark.image],
                                         position_in_world))
      mark.pixel = linear->pixel;
  if (auto state = adjusted(block, local, seen, loose, position_in_world)) return *std::move(state);
  PointState state{.position_in_world = position_in_world};
  const Eigen::Index size = 3 + local.covariance.cols();
  state.pose_steps = VectorXd::Zero(size - 3);
  state.covariance = MatrixXd::Zero(size, size);
  state.covariance.topLeftCorner<3, 3>() = 100 * distance * distance * Matrix3d::Identity();
  state.covariance.bottomRightCorner(size - 3, size - 3) = local.covariance;
  return state;
}

}  // namespace collinea
