// SPDX-License-Identifier: Apache-2.0
#include "collinea/marking/predicted_marks.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "collinea/marking/internal/point_position.h"
#include "collinea/math/median.h"

namespace collinea {
namespace {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kUsualSigma_px = 0.5;  // of a mark, where there is none to learn from
constexpr double kEqual = 1.02;

// In front of the camera and inside the image.
std::optional<Vector2d> seen_at(const Block& block, const OrientedImage& image, const Vector3d& position) {
  const Camera& camera = block.camera_of(image.image);
  const auto pixel = project(camera, image.cam_from_world * position);
  return pixel && inside(camera, *pixel) ? pixel : std::nullopt;
}

double middle_distance(const Camera& camera, const Vector2d& pixel) {
  const Vector2d size(camera.width_px, camera.height_px);
  return (pixel - size / 2).norm() / size.norm();
}

// The images that show a position, after those that are marked; where there are too many those that nothing hides, and
// of these the nearest to the middle of their format.
std::vector<ImageId> local_images(const MarkingBlock& in, const Vector3d& position,
                                  const std::vector<ControlObservation>& marks) {
  std::vector<ImageId> images;
  for (const ControlObservation& mark : marks) images.push_back(mark.image);
  std::vector<std::tuple<bool, double, ImageId>> others;
  for (const OrientedImage& one : oriented_images(in.block)) {
    if (std::find(images.begin(), images.end(), one.image) != images.end()) continue;
    const auto pixel = seen_at(in.block, one, position);
    if (!pixel) continue;
    const bool hidden = is_hidden(in.surface, position, centre_of(one.cam_from_world));
    others.emplace_back(hidden, middle_distance(in.block.camera_of(one.image), *pixel), one.image);
  }
  std::sort(others.begin(), others.end());
  for (const auto& [hidden, distance, image] : others)
    if (images.size() < std::max(kMostPredicted, marks.size())) images.push_back(image);
  return images;
}

double usual_sigma_px(const std::vector<ControlObservation>& marks) {
  std::vector<double> sigmas;
  for (const ControlObservation& mark : marks) sigmas.push_back(mark.sigma_px);
  return sigmas.empty() ? kUsualSigma_px : median(sigmas);
}

bool is_marked(const std::vector<ControlObservation>& marks, ImageId image) {
  return std::any_of(marks.begin(), marks.end(), [&](const auto& mark) { return mark.image == image; });
}

double largest_sigma(const Matrix3d& covariance) {
  return std::sqrt(std::max(0.0, Eigen::SelfAdjointEigenSolver<Matrix3d>(covariance).eigenvalues()[2]));
}

/// A predicted mark with what a mark there would tell of the point if poses were exact.
struct Candidate {
  PredictedMark mark;
  Matrix3d information;
  double from_middle;
};

// Puts candidates into the order in which marks do most beside what is known, which then holds them too.
void take_in_order(std::vector<Candidate> candidates, Matrix3d& known, std::vector<PredictedMark>& ordered) {
  while (!candidates.empty()) {
    std::vector<double> sigma;
    for (const Candidate& one : candidates) {
      const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(known + one.information);
      // One ray leaves the depth open: all are equally bad.
      const bool is_fixed = eigen.eigenvalues()[0] > 1e-9 * eigen.eigenvalues()[2];
      sigma.push_back(is_fixed ? 1 / std::sqrt(eigen.eigenvalues()[0]) : std::numeric_limits<double>::infinity());
    }
    const double best = *std::min_element(sigma.begin(), sigma.end());
    std::size_t chosen = candidates.size();
    for (std::size_t i = 0; i < candidates.size(); ++i)
      if (sigma[i] <= kEqual * best &&
          (chosen == candidates.size() || candidates[i].from_middle < candidates[chosen].from_middle))
        chosen = i;
    known += candidates[chosen].information;
    ordered.push_back(candidates[chosen].mark);
    candidates.erase(candidates.begin() + std::ptrdiff_t(chosen));
  }
}

// Those that are seen, those that are hidden, those that are marked.
std::vector<PredictedMark> in_order(const std::vector<Candidate>& candidates) {
  std::vector<PredictedMark> ordered, marked;
  std::vector<Candidate> seen, hidden;
  Matrix3d known = Matrix3d::Zero();
  for (const Candidate& one : candidates)
    if (one.mark.marked) {
      known += one.information;
      marked.push_back(one.mark);
    } else {
      (one.mark.hidden ? hidden : seen).push_back(one);
    }
  take_in_order(std::move(seen), known, ordered);
  take_in_order(std::move(hidden), known, ordered);
  ordered.insert(ordered.end(), marked.begin(), marked.end());
  return ordered;
}

std::vector<Candidate> candidates_of(const MarkingBlock& in, const LocalPoses& local, const PointState& state,
                                     const std::vector<ControlObservation>& marks) {
  const PointState alone = state_of_marks(in.block, local, marks, state.position_in_world);
  const double sigma_px = usual_sigma_px(marks);
  const Matrix2d noise = sigma_px * sigma_px * Matrix2d::Identity();
  std::vector<Candidate> candidates;
  for (std::size_t i = 0; i < local.images.size(); ++i) {
    const Camera& camera = in.block.camera_of(local.images[i]);
    const auto linear = linear_pixel(camera, local.cam_from_world[i], state.position_in_world);
    if (!linear) continue;
    Candidate one{.mark = {.image = local.images[i]}};
    one.mark.marked = is_marked(marks, one.mark.image);
    one.mark.hidden = is_hidden(in.surface, state.position_in_world, centre_of(local.cam_from_world[i]));
    MatrixXd rows = MatrixXd::Zero(2, state.covariance.cols());
    rows.leftCols<3>() = linear->by_point;
    rows.middleCols<6>(3 + 6 * Eigen::Index(i)) = linear->by_pose;
    one.mark.pixel = linear->pixel + linear->by_pose * state.pose_steps.segment<6>(6 * Eigen::Index(i));
    if (!one.mark.marked && !inside(camera, one.mark.pixel)) continue;
    one.mark.covariance = rows * state.covariance * rows.transpose();
    const MatrixXd shared = alone.covariance.topRows<3>() * rows.transpose();
    const Matrix2d innovation = rows * alone.covariance * rows.transpose() + noise;
    const Matrix3d after =
        alone.covariance.topLeftCorner<3, 3>() -
        (one.mark.marked ? Matrix3d::Zero().eval() : Matrix3d(shared * innovation.inverse() * shared.transpose()));
    const double sigma = largest_sigma(after),
                 distance = (state.position_in_world - centre_of(local.cam_from_world[i])).norm();
    if (sigma < distance) one.mark.sigma_after_m = sigma;
    one.information = linear->by_point.transpose() * noise.inverse() * linear->by_point;
    one.from_middle = middle_distance(camera, one.mark.pixel);
    candidates.push_back(one);
  }
  return candidates;
}

}  // namespace

PredictedMarks predicted_marks(const MarkingBlock& in, const ControlPoint& given,
                               const std::vector<ControlObservation>& all_marks) {
  PredictedMarks out;
  const std::vector<ControlObservation> marks = agreeing_marks(in.block, all_marks);
  for (const ControlObservation& mark : all_marks)
    if (is_oriented(in.block, mark.image) && !is_marked(marks, mark.image)) out.contradicting.push_back(mark.image);
  auto position = start_position(in, given, marks);
  // The images that see the point follow from where it lies, and that from their poses.
  std::optional<LocalPoses> local;
  std::optional<PointState> state;
  for (int pass = 0; pass < 3 && position; ++pass) {
    const std::vector<ImageId> images = local_images(in, *position, marks);
    if (local && images == local->images) break;
    local = local_poses(in.block, in.observations, images, in.poses, in.sigma0);
    if (!local) return out;
    state = state_of_point(in, *local, given, marks);
    if (!state) return out;
    position = state->position_in_world;
  }
  if (!state) return out;
  out.given_disagrees = state->given_disagrees;
  out.predicted = in_order(candidates_of(in, *local, *state, marks));
  for (PredictedMark& one : out.predicted)
    one.marked |= std::find(out.contradicting.begin(), out.contradicting.end(), one.image) != out.contradicting.end();
  out.marked =
      marked_point(in.block, {.images = local->images, .covariance = local->covariance}, point_marks(*local, marks));
  for (const ControlObservation& mark : marks) out.marked_images.push_back(mark.image);
  return out;
}

}  // namespace collinea
