// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/internal/gross_error.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "collinea/epipolar/intersect.h"

namespace collinea {
namespace {

std::vector<SightLine> lines_of(const Rejected& rejected, const Block& block) {
  if (rejected.control.valid()) return sight_lines(block, rejected.control);
  std::vector<SightLine> lines;
  for (const Observation& seen : std::ranges::equal_range(block.observations, rejected.point, {}, &Observation::point))
    if (const auto pose = find_pose(block, seen.image))
      lines.push_back({&block.camera_of(seen.image), *pose, seen.pixel, seen.sigma_px, seen.shape});
  return lines;
}

// Where a point is, as far as it is known without a rejected ray: where its other rays meet or, with fewer, as control
// is adjusted.
std::optional<std::pair<Eigen::Vector3d, Eigen::Matrix3d>> known_without(const Rejected& rejected, const Block& block,
                                                                         const Adjusted& adjusted) {
  if (const auto met = intersect(lines_of(rejected, block))) return std::pair(met->point_in_world, met->covariance);
  for (const ControlDifference& now : adjusted.control)
    if (rejected.control.valid() && now.point == rejected.control && now.position_in_world && now.covariance_m2)
      return std::pair(*now.position_in_world, *now.covariance_m2);
  return std::nullopt;
}

// Variance of a coordinate of the image of that point, all images being exact [px^2].
double variance_by_rays(const Rejected& rejected, const Block& block, const Adjusted& adjusted) {
  const auto known = known_without(rejected, block, adjusted);
  const Rigid3& pose = pose_of(block, rejected.image);
  Matrix23 by_cam;
  if (!known || !project(block.camera_of(rejected.image), pose * known->first, &by_cam, nullptr))
    return std::numeric_limits<double>::quiet_NaN();
  const Eigen::RowVector3d by_world = by_cam.row(rejected.axis) * pose.rotation.toRotationMatrix();
  return by_world * known->second * by_world.transpose();
}

void test_gross_ray(Rejection& one, const Block& block, const Adjusted& adjusted) {
  Rejected& rejected = one.rejected;
  const double size = rejected.gross_error.head<2>().norm();
  rejected.axis = std::abs(rejected.gross_error.y()) > std::abs(rejected.gross_error.x()) ? 1 : 0;
  one.cofactor = variance_by_rays(rejected, block, adjusted) / (one.sigma * one.sigma);
  if (std::isfinite(size)) rejected.w = size / one.sigma;
}

// The variance of an adjusted coordinate of a control point: what the others know of it.
std::optional<double> variance_by_others(const Rejected& rejected, const Adjusted& adjusted) {
  if (traits_of(rejected.group).source != ObservationSource::kControlCoordinates) return std::nullopt;
  for (const ControlDifference& now : adjusted.control)
    if (now.point == rejected.control && now.covariance_m2) return (*now.covariance_m2)(rejected.axis, rejected.axis);
  return std::nullopt;
}

// A coordinate that was fixed.
void test_fixed_coordinate(Rejected& rejected, const Adjusted& adjusted, double sigma0) {
  if (const auto variance = variance_by_others(rejected, adjusted)) rejected.sigma = sigma0 * std::sqrt(*variance);
  if (rejected.sigma > 0) rejected.w = std::abs(rejected.gross_error[rejected.axis]) / rejected.sigma;
}

}  // namespace

std::vector<Rejection> with_gross_errors(std::vector<Rejection> rejections, const Measurements& left,
                                         const Adjusted& adjusted, double sigma0) {
  for (Rejection& one : rejections) {
    Rejected& rejected = one.rejected;
    if (!rejected.as_pair)
      if (const auto difference = misclosure(rejected, one.given, left, adjusted))
        axes_of(rejected.group, rejected.gross_error) = axes_of(rejected.group, *difference);
    if (!(one.sigma > 0)) {
      test_fixed_coordinate(rejected, adjusted, sigma0);
      continue;
    }
    if (rejected.round == 0 && is_image_point(rejected.group)) test_gross_ray(one, left.block, adjusted);
    const double own = is_image_point(rejected.group) ? sigma0 : 1;
    rejected.sigma = one.sigma * std::sqrt(own * own + sigma0 * sigma0 * one.cofactor);
    if (const auto sigma = sigma_of_correlated(rejected, one.given, rejected.axis, sigma0, left, adjusted))
      rejected.sigma = *sigma;
  }
  return rejections;
}

}  // namespace collinea
