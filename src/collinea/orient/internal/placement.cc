// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/internal/placement.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "collinea/block/image_axes.h"
#include "collinea/orient/control_rejection.h"
#include "collinea/orient/internal/datum.h"
#include "collinea/orient/internal/geodetic_scale.h"
#include "collinea/orient/internal/gross_geodetic.h"
#include "collinea/orient/internal/level_datum.h"
#include "collinea/orient/internal/strip_datum.h"
#include "collinea/quality/mark_check.h"

namespace collinea {
namespace {

constexpr double kWeakRotation_rad = 0.03;  // of a block about the line of its positions: attitudes are better
constexpr double kUnknownRotation_rad = 0.2;
constexpr double kDegrees = 180 / std::numbers::pi;
constexpr double kLevelSigma_rad = 2 / kDegrees;  // of a block whose level nothing observes

void add(Placement& placed, FindingCode code, std::vector<Figure> figures = {}, std::vector<Remedy> remedies = {}) {
  placed.findings.push_back(finding_of(code, {}, std::move(figures), std::move(remedies)));
}

void add(Placement& placed, const std::vector<Finding>& findings) {
  placed.findings.insert(placed.findings.end(), findings.begin(), findings.end());
}

std::size_t count_positions(const Block& block) {
  return static_cast<std::size_t>(std::ranges::count_if(oriented_images(block), [&](const OrientedImage& one) {
    return block.images.at(one.image).position.has_value();
  }));
}

void check_control_of(Reconstruction& part, Placement& placed, const OrientOptions& options, std::uint64_t seed) {
  const bool expects_shift = options.instruments.position_shift != PositionShift::kNone;
  CheckedSetup checked = reject_wrong_control(part.block(), part.setup(), expects_shift, seed);
  part.set_setup(std::move(checked.setup));
  placed.excluded_control = std::move(checked.excluded);
  add(placed, checked.findings);
}

// Marks that import kept although they lie outside their images, to find out how they were counted.
void leave_out_marks_outside(Reconstruction& part) {
  Block setup = part.setup();
  const std::size_t before = setup.control_observations.size();
  remove_marks_outside(setup);
  if (setup.control_observations.size() < before) part.set_setup(std::move(setup));
}

// Without control or positions the gauge is made readable: origin in the middle of the cameras, z opposite to the mean
// lower edge of the images as they are looked at, the unit such that the first base had length one.
Similarity3 readable_gauge(const Reconstruction& part) {
  Eigen::Vector3d up = Eigen::Vector3d::Zero(), middle = Eigen::Vector3d::Zero();
  for (const auto& [image, pose] : part.poses()) {
    up -= pose.rotation.conjugate() * down_in_cam(part.setup().images.at(image).orientation);
    middle += centre_of(pose) / static_cast<double>(part.poses().size());
  }
  Similarity3 gauge;
  if (up.norm() > 1e-6) gauge.rotation = Eigen::Quaterniond::FromTwoVectors(up, Eigen::Vector3d::UnitZ());
  gauge.translation = -(gauge.rotation * middle);
  return gauge;
}

// Positions that do not observe the tilt must not change it: the attitudes do or, without any, it stays to two degrees.
std::map<ImageId, GivenVertical> present_level(const Reconstruction& part) {
  auto verticals = verticals_by_attitude(part.block());
  if (!verticals.empty()) return verticals;
  const double sigma_rad = kLevelSigma_rad * std::sqrt(static_cast<double>(part.poses().size()));
  for (const auto& [image, pose] : part.poses())
    verticals[image] = {pose.rotation * Eigen::Vector3d::UnitZ(), sigma_rad};
  return verticals;
}

void leave_out_geodetic(Reconstruction& part, const std::vector<std::size_t>& excluded, Placement& placed) {
  Block setup = part.setup();
  for (const std::size_t index : excluded) setup.geodetic[index].role = ControlRole::kCheck;
  part.set_setup(std::move(setup));
  placed.excluded_geodetic.insert(excluded.begin(), excluded.end());
}

// A local frame gets at least its scale, by distances. Those that contradict the others are rejected. Without any that
// can be compared, geodetic observations are not used.
void scale_by_distances(Reconstruction& part, const GivenOrientation* given, Placement& placed) {
  if (!placed.scope.use_geodetic) return;
  const auto found = geodetic_scale(part.block());
  placed.scope.use_geodetic = found.has_value();
  if (!found) return;
  leave_out_geodetic(part, found->excluded, placed);
  add(placed, found->findings);
  Similarity3 scaled;
  scaled.scale = found->scale;
  part.move_world(scaled);
  placed.metric = true;
  placed.gauge = {.given_by = given ? given->source : "", .distances = static_cast<std::uint64_t>(found->distances)};
}

// A model from elsewhere stays where it lies when that is the map, or when nothing here knows better.
std::optional<Placement> placed_as_given(Reconstruction& part, const GivenOrientation& given,
                                         const OrientOptions& options, Placement placed) {
  const auto& georeference = part.setup().georeference;
  const bool in_map = georeference && (given.in_world || lies_in_world(part.block()));
  const bool knows_better = georeference && !in_map && (options.use_positions || options.use_control);
  if (knows_better) return std::nullopt;
  placed.georeferenced = in_map;
  placed.gauge = {.map = in_map ? georeference->crs : "", .given_by = given.source};
  placed.scope.use_positions &= in_map;
  placed.scope.use_control &= in_map;
  if (!in_map) scale_by_distances(part, &given, placed);
  if (placed.scope.use_positions && rotation_sigma_rad(part.block(), 1) > kWeakRotation_rad)
    placed.scope.verticals = present_level(part);
  return placed;
}

Placement placed_by_similarity(Reconstruction& part, const Datum& found, Placement placed) {
  part.move_world(found.world_from_block);
  placed.in_datum = {found.control.begin(), found.control.end()};
  placed.georeferenced = true;
  const std::size_t positions = placed.scope.use_positions ? count_positions(part.block()) : 0;
  placed.gauge = {.map = part.setup().georeference->crs, .by_control = found.by_control, .positions = positions};
  return placed;
}

// Positions on one line: attitudes fix the rotation about it, with their sigma.
std::optional<Placement> placed_by_strip(Reconstruction& part, Placement placed) {
  const auto found = strip_datum(part.block());
  if (!found) return std::nullopt;
  part.move_world(*found);
  placed.scope.verticals = verticals_by_attitude(part.block());
  placed.georeferenced = true;
  placed.gauge = {.map = part.setup().georeference->crs,
                  .positions = count_positions(part.block()),
                  .position_use = PositionUse::kOnLine};
  add(placed, FindingCode::kPositionsOnLine, {}, {RemedyCode::kAddStripOrControl});
  return placed;
}

FindingCode finding_of_level(LevelSource level) {
  switch (level) {
    case LevelSource::kEdges:
      return FindingCode::kLevelByEdges;
    case LevelSource::kView:
      return FindingCode::kLevelByView;
    case LevelSource::kLowerEdges:
      return FindingCode::kLevelByLowerEdges;
    default:
      return FindingCode::kLevelByAttitudes;
  }
}

// Positions that observe no tilt, without heights or too close together: what is level comes from the images.
std::optional<Placement> placed_by_level(Reconstruction& part, Placement placed) {
  auto found = level_datum(part.block());
  if (!found) return std::nullopt;
  part.move_world(found->world_from_block);
  placed.scope.verticals = std::move(found->verticals);
  placed.georeferenced = true;
  placed.gauge = {.map = part.setup().georeference->crs,
                  .positions = found->positions,
                  .position_use = found->heights ? PositionUse::kSpace : PositionUse::kPlan,
                  .level = found->level_by};
  add(placed, finding_of_level(found->level_by),
      {{FigureName::kHeights, static_cast<double>(found->heights)},
       {FigureName::kSigmaAngle, found->level_sigma_rad * kDegrees},
       {FigureName::kSigmaScale, found->rotation_sigma_rad},
       {FigureName::kSigmaAzimuth, found->rotation_sigma_rad * kDegrees}},
      {RemedyCode::kGiveThreeControlPoints});
  placed.relative_heights = found->heights == 0;
  if (placed.relative_heights) add(placed, FindingCode::kHeightsRelative);
  return placed;
}

// The part in the world, by control and positions. Nothing where they do not fix it.
std::optional<Placement> placed_in_world(Reconstruction& part, std::uint64_t seed, const Placement& begun) {
  const AdjustScope& scope = begun.scope;
  const auto found = datum(part.block(), scope.use_positions, scope.use_control, seed);
  if (scope.use_positions && (!found || found->control.empty())) {
    const double rotation_rad =
        found ? rotation_sigma_rad(part.block(), found->world_from_block.scale) : kUnknownRotation_rad;
    if (rotation_rad > kWeakRotation_rad)
      if (auto placed = placed_by_strip(part, begun)) return placed;
    if (rotation_rad >= kUnknownRotation_rad) return placed_by_level(part, begun);
  }
  return found ? std::optional(placed_by_similarity(part, *found, begun)) : std::nullopt;
}

Placement placed_locally(Reconstruction& part, const GivenOrientation* given, Placement placed) {
  placed.scope.use_positions = placed.scope.use_control = false;
  if (given)
    placed.gauge.given_by = given->source;
  else
    part.move_world(readable_gauge(part));
  scale_by_distances(part, given, placed);
  if (part.setup().georeference) add(placed, FindingCode::kLocalGauge);
  return placed;
}

// What was measured on the ground takes part in the world, less what cannot be there.
void check_geodetic(Reconstruction& part, Placement& placed) {
  if (!placed.georeferenced || !placed.scope.use_geodetic || part.setup().geodetic.empty()) return;
  if (!placed.scope.verticals.empty()) return;  // the block is level by its images: heights on the ground know better
  const Block block = part.block();
  const bool by_control = placed.gauge.by_control;
  const std::set<ControlId> control = by_control ? placed.in_datum : std::set<ControlId>{};
  const GrossGeodetic found = gross_geodetic(block, known_part(block, control, rotation_sigma_rad(block, 1)));
  if (found.excluded.empty()) return;
  leave_out_geodetic(part, found.excluded, placed);
  add(placed, found.findings);
}

Placement placed_where_known(Reconstruction& part, const GivenOrientation* given, const OrientOptions& options,
                             std::uint64_t seed, Placement begun) {
  const bool has_map = part.setup().georeference.has_value();
  if (given)
    if (auto placed = placed_as_given(part, *given, options, begun)) return *std::move(placed);
  if (has_map)
    if (auto placed = placed_in_world(part, seed, begun)) return *std::move(placed);
  return placed_locally(part, given, std::move(begun));
}

}  // namespace

Placement set_datum(Reconstruction& part, const GivenOrientation* given, const OrientOptions& options,
                    std::uint64_t seed) {
  const bool has_map = part.setup().georeference.has_value();
  Placement begun;
  begun.scope = {
      .use_positions = options.use_positions, .use_control = options.use_control, .use_geodetic = options.use_geodetic};
  if (has_map && options.use_control)
    check_control_of(part, begun, options, seed);
  else
    leave_out_marks_outside(part);
  Placement placed = placed_where_known(part, given, options, seed, std::move(begun));
  check_geodetic(part, placed);
  return placed;
}

}  // namespace collinea
