// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/internal/participants.h"

#include <algorithm>
#include <map>
#include <utility>

#include "collinea/adjust/internal/gather_geodetic.h"

namespace collinea::bundle {
namespace {

constexpr int kLeastRaysOfImage = 3;

// Rays of a point in images that take part.
int rays_of(const Participants& participants, const CandidatePoint& point) {
  int rays = 0;
  for (std::uint32_t r = point.first_ray; r < point.end_ray; ++r)
    rays += participants.has_image[participants.points.rays[r].image];
  return rays;
}

// Image measurements, coordinates and geodetic observations together are as many as its unknowns.
bool is_determined_with(const CandidatePoint& point, int rays, int geodetic) {
  return point.is_fixed || 2 * rays + point.given + geodetic >= 3;
}

// Enough observations remain of the point. `counts`: see geodetic_counts().
bool is_strong(const Participants& participants, const CandidatePoint& point, const std::map<ControlId, int>& counts) {
  const int rays = rays_of(participants, point);
  const bool is_seen = rays >= point.least_rays && rays > 0;
  const auto its = point.is_linked ? counts.find(ControlId{point.id}) : counts.end();
  const bool is_linked = its != counts.end();
  if (point.is_geodetic_only && !is_linked) return false;
  return is_seen || (is_linked && is_determined_with(point, rays, its->second));
}

// Rejects points; answers how many rays of the others each image has.
std::vector<int> reject_points(const Block& block, Participants& participants) {
  const std::map<ControlId, int> counts = geodetic_counts(block, participants.points.geodetic);
  std::vector<int> rays(participants.has_image.size(), 0);
  for (std::size_t p = 0; p < participants.has_point.size(); ++p) {
    if (!participants.has_point[p]) continue;
    const CandidatePoint& point = participants.points.points[p];
    participants.has_point[p] = is_strong(participants, point, counts);
    for (std::uint32_t r = point.first_ray; r < point.end_ray && participants.has_point[p]; ++r)
      ++rays[participants.points.rays[r].image];
  }
  return rays;
}

// Rejects free images with too few rays; true when there was one.
bool reject_images(const std::vector<int>& rays, Participants& participants) {
  bool changed = false;
  for (std::size_t i = 0; i < rays.size(); ++i)
    if (participants.is_unknown(i) && rays[i] < kLeastRaysOfImage) {
      participants.has_image[i] = false;
      changed = true;
    }
  return changed;
}

// Rejects geodetic observations of points that take no part; true when there was one.
bool reject_geodetic(const Block& block, Participants& participants) {
  std::vector<std::uint32_t>& geodetic = participants.points.geodetic;
  if (geodetic.empty()) return false;
  std::map<ControlId, Eigen::Vector3d> positions;
  for (std::size_t p = 0; p < participants.has_point.size(); ++p)
    if (const CandidatePoint& point = participants.points.points[p]; participants.has_point[p] && point.control >= 0)
      positions.emplace(ControlId{point.id}, Eigen::Vector3d(point.position));
  const std::size_t before = geodetic.size();
  std::erase_if(geodetic, [&](std::uint32_t source) {
    return !positions.contains(block.geodetic[source].from) || !positions.contains(block.geodetic[source].to);
  });
  erase_weak_shapes(
      block, [&](ControlId id) { return positions.at(id); }, geodetic);
  return geodetic.size() < before;
}

}  // namespace

Participants reject_weak(const Block& block, CandidateImages images, CandidatePoints points) {
  Participants participants;
  participants.has_image.assign(images.images.size(), true);
  participants.has_point.assign(points.points.size(), true);
  participants.images = std::move(images);
  participants.points = std::move(points);
  const std::size_t geodetic = participants.points.geodetic.size();
  std::vector<int> rays;
  for (bool changed = true; changed;) {
    rays = reject_points(block, participants);
    changed = reject_images(rays, participants);
    changed |= reject_geodetic(block, participants);
  }
  participants.geodetic_left_out = geodetic - participants.points.geodetic.size();
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const CandidateImage& image = participants.images.images[i];
    if (image.is_free && !participants.has_image[i]) participants.images_left_out.push_back(image.id);
    if (rays[i] == 0) participants.has_image[i] = false;
  }
  return participants;
}

Result<> check_there_is_something(const Participants& participants, const AdjustScope& scope,
                                  const AdjustOptions& options) {
  const std::vector<bool>& has_point = participants.has_point;
  if (participants.images.images.empty())
    return fail(Errc::kIllPosed, "no image is oriented: there is nothing to adjust");
  if (std::find(has_point.begin(), has_point.end(), true) == has_point.end())
    return fail(Errc::kIllPosed,
                "no point is measured in two images that take part: there is nothing to adjust. Measure tie "
                "points in a second image, or control points known in plan and height");
  bool has_unknown_image = false;
  for (std::size_t i = 0; i < participants.has_image.size(); ++i) has_unknown_image |= participants.is_unknown(i);
  if (!has_unknown_image && options.calibration == Calibration::kNone && scope.camera_sigmas.empty() &&
      std::all_of(participants.points.points.begin(), participants.points.points.end(),
                  [](const CandidatePoint& point) { return point.is_fixed; }))
    return fail(Errc::kIllPosed, "every image, camera and point is fixed: there is nothing to adjust");
  return {};
}

}  // namespace collinea::bundle
