// SPDX-License-Identifier: Apache-2.0
#include "collinea/restitution/stereo_pairs.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "collinea/restitution/stereo_geometry.h"

namespace collinea {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

/// An image that shows the place.
struct Seen {
  ImageId image;
  Vector3d to_centre;  // to the projection centre
  double gsd_m = 0;
  double from_middle = 0;
  bool is_hidden = false;
  LinearPixel linear;
};

std::optional<Seen> seen_in(const MarkingBlock& in, ImageId image, const Vector3d& position, double rim) {
  const Camera& camera = in.block.camera_of(image);
  const Rigid3 pose = pose_of(in.block, image);
  const auto linear = linear_pixel(camera, pose, position);
  if (!linear || !linear->pixel.allFinite()) return std::nullopt;
  const Vector2d size(camera.width_px, camera.height_px), share = linear->pixel.cwiseQuotient(size);
  if (!(share.minCoeff() >= rim && share.maxCoeff() <= 1 - rim)) return std::nullopt;
  const Vector3d way = centre_of(pose) - position;
  // A pixel on the ground: across the ray the image moves by the singular values of its derivatives.
  const Eigen::Matrix2d squares = linear->by_point * linear->by_point.transpose();
  const double gsd = std::pow(squares.determinant(), -0.25);
  if (!std::isfinite(gsd)) return std::nullopt;
  const double from_middle = 2 * (share - Vector2d(0.5, 0.5)).cwiseAbs().maxCoeff();
  return Seen{image, way, gsd, from_middle, is_hidden(in.surface, position, centre_of(pose)), *linear};
}

double angle_between(const Vector3d& a, const Vector3d& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

// Of the height, by both rays; nothing where they do not fix it.
std::optional<double> height_sigma(const Seen& one, const Seen& other, const LocalPoses* poses) {
  Matrix3d normal = Matrix3d::Zero();
  constexpr double kWeight = 1 / (kPointing_px * kPointing_px);
  for (const Seen* seen : {&one, &other}) normal += kWeight * seen->linear.by_point.transpose() * seen->linear.by_point;
  const Eigen::LLT<Matrix3d> solver(normal);
  if (solver.info() != Eigen::Success) return std::nullopt;
  const Matrix3d own = solver.solve(Matrix3d::Identity());
  double variance = own(2, 2);
  if (poses) {
    Eigen::RowVectorXd by_poses = Eigen::RowVectorXd::Zero(poses->covariance.cols());
    for (const Seen* seen : {&one, &other}) {
      const auto found = std::ranges::find(poses->images, seen->image);
      if (found == poses->images.end()) return std::nullopt;
      by_poses.segment<6>(6 * std::distance(poses->images.begin(), found)) -=
          (own * seen->linear.by_point.transpose() * kWeight * seen->linear.by_pose).row(2);
    }
    variance += by_poses * poses->covariance * by_poses.transpose();
  }
  return std::isfinite(variance) && variance > 0 ? std::optional(std::sqrt(variance)) : std::nullopt;
}

Result<StereoChoice> choice_of(const MarkingBlock& in, const Seen& one, const Seen& other, const Vector3d& position,
                               const LocalPoses* poses) {
  COLLINEA_TRY(const StereoGeometry model, StereoGeometry::of(in.block, one.image, other.image));
  const Seen &left = model.left == one.image ? one : other, &right = model.left == one.image ? other : one;
  StereoChoice choice{.images = {left.image, right.image}, .gsd_m = {left.gsd_m, right.gsd_m}};
  choice.base_to_height = model.pair.base_m / (model.pair.left_from_world * position).z();
  choice.convergence_rad = angle_between(left.to_centre, right.to_centre);
  choice.sigma_height_m = height_sigma(left, right, poses);
  choice.from_middle = std::max(left.from_middle, right.from_middle);
  choice.is_hidden = left.is_hidden || right.is_hidden;
  return choice;
}

std::optional<LocalPoses> poses_of(const MarkingBlock& in, const std::vector<ImageId>& images) {
  return in.poses.empty() ? std::nullopt : local_poses(in.block, in.observations, images, in.poses, in.sigma0);
}

bool can_be_seen(const Seen& one, const Seen& other) {
  const double angle = angle_between(one.to_centre, other.to_centre);
  const double scale = std::max(one.gsd_m, other.gsd_m) / std::min(one.gsd_m, other.gsd_m);
  return angle >= kLeastConvergence_rad && angle <= kMostConvergence_rad && scale <= kMostScale;
}

// By the standard deviation; those that are equal within kEqualSigma to the best that is left by what is around the
// place.
void put_in_order(std::vector<StereoChoice>& choices) {
  std::ranges::stable_sort(choices, {},
                           [](const StereoChoice& one) { return std::pair(one.is_hidden, *one.sigma_height_m); });
  for (auto next = choices.begin(); next != choices.end(); ++next) {
    const auto end = std::find_if(next, choices.end(), [&](const StereoChoice& one) {
      return one.is_hidden != next->is_hidden || *one.sigma_height_m > kEqualSigma * *next->sigma_height_m;
    });
    const auto best = std::ranges::min_element(next, end, {}, &StereoChoice::from_middle);
    std::rotate(next, best, best + 1);
  }
}

}  // namespace

std::vector<StereoChoice> stereo_choices(const MarkingBlock& in, const Vector3d& position) {
  std::vector<Seen> seen;
  for (const OrientedImage& image : oriented_images(in.block))
    if (const auto one = seen_in(in, image.image, position, kRim)) seen.push_back(*one);
  std::ranges::stable_sort(seen, {}, [](const Seen& one) { return std::pair(one.is_hidden, one.to_centre.norm()); });
  if (seen.size() > kMostSeen) seen.resize(kMostSeen);
  std::vector<ImageId> images;
  for (const Seen& one : seen) images.push_back(one.image);
  std::ranges::sort(images);
  const auto poses = poses_of(in, images);
  std::vector<StereoChoice> choices;
  for (std::size_t i = 0; i < seen.size(); ++i)
    for (std::size_t j = i + 1; j < seen.size(); ++j) {
      if (!can_be_seen(seen[i], seen[j])) continue;
      const auto choice = choice_of(in, seen[i], seen[j], position, poses ? &*poses : nullptr);
      if (choice && choice->sigma_height_m) choices.push_back(*choice);
    }
  put_in_order(choices);
  if (choices.size() > kMostStereoChoices) choices.resize(kMostStereoChoices);
  return choices;
}

Result<StereoChoice> stereo_choice(const MarkingBlock& in, ImageId one, ImageId other, const Vector3d& position) {
  COLLINEA_TRY([[maybe_unused]] const StereoGeometry model, StereoGeometry::of(in.block, one, other));
  const auto first = seen_in(in, one, position, 0), second = seen_in(in, other, position, 0);
  if (!first || !second) return fail(Errc::kIllPosed, "the position is not in both photographs");
  const auto poses = poses_of(in, {std::min(one, other), std::max(one, other)});
  return choice_of(in, *first, *second, position, poses ? &*poses : nullptr);
}

}  // namespace collinea
