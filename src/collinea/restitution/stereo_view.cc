// SPDX-License-Identifier: Apache-2.0
#include "collinea/restitution/stereo_view.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "collinea/math/median.h"

namespace collinea {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// By the tie points nearest in plan; nothing where there are none.
std::optional<double> height_of_ties(const Block& block, const Vector2d& at) {
  std::vector<std::pair<double, double>> near;  // squared distance, height
  for (const auto& [id, point] : block.points)
    near.emplace_back((point.position_in_world.head<2>() - at).squaredNorm(), point.position_in_world.z());
  if (near.empty()) return std::nullopt;
  const std::size_t count = std::min(kNearTies, near.size());
  std::ranges::partial_sort(near, near.begin() + std::ptrdiff_t(count));
  std::vector<double> heights;
  for (std::size_t i = 0; i < count; ++i) heights.push_back(near[i].second);
  return median(heights);
}

// A height of the map and one of the world are the same but for the curvature: a few turns bring them together.
Result<Vector3d> position_on_map(const MarkingBlock& in, const LocalFrame* frame, const MapHeight& surface,
                                 const Vector2d& on_map) {
  const auto in_world = [&](const Vector3d& map) { return frame ? frame->local_from_map(map) : map; };
  if (const auto height = surface ? surface(on_map) : std::nullopt) return in_world({on_map.x(), on_map.y(), *height});
  Vector3d map(on_map.x(), on_map.y(), 0);
  for (int turn = 0; turn < 3; ++turn) {
    const Vector3d world = in_world(map);
    if (!world.allFinite()) return fail(Errc::kBadInput, "the position lies outside of where the map is defined");
    const auto height = height_of_ties(in.block, world.head<2>());
    if (!height)
      return fail(Errc::kIllPosed, "there are neither a surface nor tie points: bring the project to orient");
    map.z() += *height - world.z();
  }
  return in_world(map);
}

Result<Vector3d> position_in_both(const MarkingBlock& in, ImageId one, ImageId other) {
  std::set<PointId> of_one;
  std::vector<Vector3d> shared;
  const auto seen_by = [&](ImageId image, const auto& take) {
    const auto found = in.observations.find(image);
    if (found == in.observations.end()) return;
    for (const std::size_t i : found->second) take(in.block.observations[i].point);
  };
  seen_by(one, [&](PointId point) { of_one.insert(point); });
  seen_by(other, [&](PointId point) {
    const auto position = in.block.points.find(point);
    if (of_one.contains(point) && position != in.block.points.end())
      shared.push_back(position->second.position_in_world);
  });
  if (shared.empty()) return fail(Errc::kIllPosed, "the photographs have no tie point in common");
  Vector3d middle = Vector3d::Zero();
  for (const Vector3d& one_of_them : shared) middle += one_of_them / double(shared.size());
  return *std::ranges::min_element(shared, {}, [&](const Vector3d& at) { return (at - middle).norm(); });
}

double reach_of(const Block& block, const StereoGeometry& model, const Vector3d& position) {
  constexpr double kMost_m = 5000;
  double reach = 1;
  for (const ImageId image : {model.left, model.right}) {
    const Camera& camera = block.camera_of(image);
    const double diagonal = std::hypot(camera.width_px, camera.height_px);
    reach = std::max(reach, (centre_of(pose_of(block, image)) - position).norm() * diagonal / camera.focal_px());
  }
  return std::min(reach, kMost_m);
}

}  // namespace

Result<StereoView> stereo_view(const MarkingBlock& given, const LocalFrame* frame, const MapHeight& surface,
                               const AskedStereo& asked) {
  if (!asked.on_map && !asked.images) return fail(Errc::kBadInput, "name a position or two photographs");
  if (count_oriented(given.block) < 2)
    return fail(Errc::kIllPosed, "the images are not oriented yet: bring the project to the step orient first");
  MarkingBlock in = given;
  in.surface = surface_in_world(frame, surface);
  if (asked.images) COLLINEA_TRY(StereoGeometry::of(in.block, asked.images->first, asked.images->second));
  COLLINEA_TRY(const Vector3d position, asked.on_map ? position_on_map(in, frame, surface, *asked.on_map)
                                                     : position_in_both(in, asked.images->first, asked.images->second));
  std::vector<StereoChoice> choices = stereo_choices(in, position);
  if (choices.empty() && !asked.images)
    return fail(Errc::kIllPosed, "no two photographs show this position so that it can be seen in stereo");
  StereoChoice shown;
  if (asked.images) {
    COLLINEA_TRY(shown, stereo_choice(in, asked.images->first, asked.images->second, position));
  } else {
    shown = choices.front();
  }
  COLLINEA_TRY(StereoGeometry model, StereoGeometry::of(in.block, shown.images[0], shown.images[1]));
  const auto mark = model.mark_at(position);
  if (!mark) return fail(Errc::kIllPosed, "the position lies behind the cameras");
  const EpipolarPair& pair = model.pair;
  COLLINEA_TRY(PixelLattice left, pixel_lattice(in.block.camera_of(model.left), pair.left_from_image, pair.left));
  COLLINEA_TRY(PixelLattice right, pixel_lattice(in.block.camera_of(model.right), pair.right_from_image, pair.right));
  MapPolynomial map = map_polynomial(frame, position, reach_of(in.block, model, position));
  return StereoView{std::move(model),   *mark,           position,         shown,
                    std::move(choices), std::move(left), std::move(right), std::move(map)};
}

}  // namespace collinea
