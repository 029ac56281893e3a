// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/orient.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>

#include "collinea/block/image_axes.h"
#include "collinea/block/world_frame.h"
#include "collinea/epipolar/intersect.h"
#include "collinea/geometry/robust_similarity.h"
#include "collinea/math/median.h"
#include "collinea/orient/additional.h"
#include "collinea/orient/given.h"
#include "collinea/orient/internal/control_doubt.h"
#include "collinea/orient/internal/datum.h"
#include "collinea/orient/internal/geodetic_findings.h"
#include "collinea/orient/internal/geodetic_scale.h"
#include "collinea/orient/internal/global.h"
#include "collinea/orient/internal/incremental.h"
#include "collinea/orient/internal/instrument_findings.h"
#include "collinea/orient/internal/level_datum.h"
#include "collinea/orient/internal/strip_datum.h"
#include "collinea/orient/internal/weak_cases.h"
#include "collinea/quality/control_check.h"

namespace collinea {
namespace {

constexpr double kLeastSigma0 = 1e-3;   // of exact data
constexpr double kControlMisfit = 2.5;  // of control's own sigma0: what no chance explains
constexpr int kControlRounds = 10;
constexpr double kFewFit = 0.5;         // of the tie points: wrong matches alone are far fewer
constexpr int kHeldRounds = 2;          // points that fit appear in the first, those they outvoted go in the second
constexpr double kWeakTurn_rad = 0.03;  // of a block about the line of its positions: attitudes are better
constexpr double kNoTurn_rad = 0.2;     // not known
constexpr double kDegrees = 180 / std::numbers::pi;
constexpr std::size_t kSmallestPart = 3;  // images of a part that is named as one; of two each stands alone

struct Parts {
  Reconstruction largest;
  bool in_world = false;  // it was placed by the positions of its images
  std::vector<std::vector<ImageId>> others;
};

std::vector<ImageId> images_of(const Reconstruction& part) {
  std::vector<ImageId> images;
  for (const auto& [image, pose] : part.poses()) images.push_back(image);
  return images;
}

bool begins_globally(const Block& setup, const OrientOptions& options) {
  return options.mode == OrientMode::kGlobal ||
         (options.mode == OrientMode::kAuto && options.use_positions && worth_global(setup));
}

// Grows parts until no two images are left that fit together; the largest is kept.
Result<Parts> grow_parts(const Block& setup, Reconstruction empty, std::span<const ImagePair> pairs,
                         const OrientOptions& options, const Run& run) {
  Parts parts{std::move(empty), false, {}};
  Reconstruction& largest = parts.largest;
  if (begins_globally(setup, options)) {
    COLLINEA_TRY(parts.in_world, place_globally(largest, setup, pairs, options, run));
    if (!parts.in_world && options.mode == OrientMode::kGlobal)
      return fail(Errc::kIllPosed,
                  "the positions of the images do not fix the block (too few, all on one line, or they contradict "
                  "the pairs): orient image after image",
                  {"mode"_option});
  }
  COLLINEA_TRY(grow(largest, pairs, {}, options, run));
  if (largest.poses().size() < 2) return tl::unexpected(nothing_fits(pairs));
  std::set<ImageId> taken;
  for (const auto& [image, pose] : largest.poses()) taken.insert(image);
  std::optional<Reconstruction> part;  // it holds all tracks: there are two at most
  while (can_start(pairs, taken)) {
    if (!part) part = largest;
    part->forget();
    COLLINEA_TRY(grow(*part, pairs, taken, options, run));
    if (part->poses().size() < 2) break;
    for (const auto& [image, pose] : part->poses()) taken.insert(image);
    if (part->poses().size() > largest.poses().size()) {
      std::swap(*part, largest);
      parts.in_world = false;
    }
    if (part->poses().size() >= kSmallestPart) parts.others.push_back(images_of(*part));
  }
  return parts;
}

// Without control or positions the gauge is made readable: origin in the middle of the cameras, z opposite to the mean
// lower edge of the pictures as they are looked at, the unit such that the first base had length one.
Similarity3 readable_gauge(const Reconstruction& part, const Block& setup) {
  Eigen::Vector3d up = Eigen::Vector3d::Zero(), middle = Eigen::Vector3d::Zero();
  for (const auto& [image, pose] : part.poses()) {
    up -= pose.rotation.conjugate() * down_in_cam(setup.images.at(image).orientation);
    middle += centre_of(pose) / static_cast<double>(part.poses().size());
  }
  Similarity3 gauge;
  if (up.norm() > 1e-6) gauge.rotation = Eigen::Quaterniond::FromTwoVectors(up, Eigen::Vector3d::UnitZ());
  gauge.translation = -(gauge.rotation * middle);
  return gauge;
}

double median_pixel_m(const Block& block) {
  std::vector<double> sizes;
  for (const Observation& seen : block.observations) {
    const double depth_m = (pose_of(block, seen.image) * block.points.at(seen.point).position_in_world).z();
    sizes.push_back(depth_m / block.camera_of(seen.image).focal_px());
  }
  return sizes.empty() ? 0 : median(sizes);
}

std::size_t count_positions(const Block& block) {
  return static_cast<std::size_t>(std::ranges::count_if(oriented_images(block), [&](const OrientedImage& one) {
    return block.images.at(one.image).position.has_value();
  }));
}

// Of the cameras that moved in an adjustment: what was free, by the rule of adjust().
CalibrationUsed calibration_used(const Adjusted& adjusted, const AdjustScope& scope, Calibration parameters) {
  CalibrationUsed used;
  for (const auto& [id, camera] : adjusted.cameras) {
    const auto own = scope.camera_sigmas.find(id);
    const CameraSigmas sigmas = own != scope.camera_sigmas.end() ? own->second : calibration_sigmas(parameters, camera);
    for (const int param : params_of(camera))
      if (sigmas[std::size_t(param)] > 0) used.free[id].push_back(param);
  }
  if (!used.free.empty()) used.parameters = parameters;
  return used;
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

class Orienter {
 public:
  Orienter(const Block& setup, const KeypointSource& keypoints, const PictureSource& pictures,
           const OrientOptions& options, const Run& run)
      : keypoints_(keypoints), pictures_(pictures), setup_(setup), options_(options), run_(run) {}

  Result<Orientation> orient(std::span<const ImagePair> pairs) {
    COLLINEA_TRY(Reconstruction empty, Reconstruction::create(setup_, pairs, keypoints_, options_));
    empty.sleep_surplus();
    COLLINEA_TRY(Parts parts, grow_parts(setup_, std::move(empty), pairs, options_, run_));
    result_.other_parts = std::move(parts.others);
    Reconstruction& part = parts.largest;
    part.wake_all();
    part.extend_all(run_);
    return settle_in_world(part, pairs, parts.in_world);
  }

  // The tie points of poses that are there; these are adjusted only when that was asked for.
  Result<Orientation> orient_from(const GivenOrientation& given, std::span<const ImagePair> pairs) {
    given_ = &given;
    for (const auto& [id, camera] : given.cameras) setup_.cameras.at(id) = camera;
    COLLINEA_TRY(Reconstruction part, Reconstruction::create(setup_, pairs, keypoints_, options_));
    part.place(given.cam_from_world);
    part.extend_all(run_);
    if (run_.stopped()) return fail(Errc::kCancelled, "stopped");
    if (part.point_count() == 0)
      return fail(Errc::kIllPosed, "no tie point fits the poses of " + given.source +
                                       ": they are not of these photographs, or their cameras are wrong");
    const auto rays = part.ray_count();
    if (static_cast<double>(rays.active) < kFewFit * static_cast<double>(rays.all))
      add(FindingCode::kFewFitGiven, {Subject::file(given.source)},
          {{FigureName::kCount, static_cast<double>(rays.active)}, {FigureName::kOf, static_cast<double>(rays.all)}});
    if (options_.refine_orientation) return settle_in_world(part, pairs, false);
    return hold(part);
  }

 private:
  // Poses stay; cameras that nobody gave and points are estimated on them.
  Result<Orientation> hold(Reconstruction& part) {
    AdjustScope held{.use_positions = false, .use_control = false, .use_ground = false};
    for (const auto& [image, pose] : part.poses()) held.fixed_images.insert(image);
    AdjustOptions adjust = settled_options(part, options_);
    if (!given_->cameras.empty()) adjust.calibration = Calibration::kNone;
    for (int round = 0; round < kHeldRounds; ++round) {
      COLLINEA_TRY(part.adjust_all(adjust, held, run_));
      part.filter(options_.max_error_px, run_);
      part.extend_all(run_);
      if (const auto shown = part.shown_noise()) part.set_noise(*shown);
    }
    if (options_.additional != AdditionalSet::kNone)
      add(FindingCode::kAdditionalHeld, {}, {}, {OptionName{"refine_orientation", "orient"}});
    doubt_loose(part);
    place(part);
    COLLINEA_TRY(Adjusted adjusted, part.adjust_all(adjust, held, run_));
    result_.adjusted = Examined{std::move(adjusted)};
    result_.calibration = calibration_used(result_.adjusted, held, adjust.calibration);
    result_.holds_given_poses = true;
    for (ControlDifference& control : result_.adjusted.control) control.used |= in_datum_.contains(control.point);
    finish(part);
    return std::move(result_);
  }

  // Given poses that hardly a tie point fits are held all the same, but that is said.
  void doubt_loose(const Reconstruction& part) {
    std::vector<ImageId> loose;
    for (const auto& [image, pose] : part.poses())
      if (part.active_rays(image) < options_.min_points) loose.push_back(image);
    if (!loose.empty())
      add(FindingCode::kLooseGiven, {loose.front()},
          {{FigureName::kLimit, static_cast<double>(options_.min_points)},
           {FigureName::kCount, static_cast<double>(loose.size())}});
  }

  Result<Orientation> settle_in_world(Reconstruction& part, std::span<const ImagePair> pairs, bool in_world) {
    // A part that lies in the world by its positions keeps them: without them a large block only sways.
    AdjustScope by_itself{
        .use_positions = in_world && options_.use_positions, .use_control = false, .use_ground = false};
    COLLINEA_TRY(Adjusted settled, settle(part, by_itself, options_, true, run_));
    if (options_.additional != AdditionalSet::kNone) {
      by_itself.camera_sigmas = add_parameters(part);
      COLLINEA_TRY(settled, settle(part, by_itself, options_, true, run_));
    }
    if (options_.remeasure && pictures_) {
      const Block measured = part.block();
      COLLINEA_TRY(const auto places_px, remeasure(measured, keypoints_, pictures_, run_));
      part.move_rays(measured, places_px);
      COLLINEA_TRY(settled, settle(part, by_itself, options_, true, run_));
    }
    if (const auto shown = part.shown_noise()) part.set_noise(*shown);
    if (const auto gross = part.leave_out_gross(run_)) {
      result_.gross_measurements = *gross;
      COLLINEA_TRY(settled, settle(part, by_itself, options_, false, run_));
    }
    take_sigma(part, settled.sigma0);
    AdjustScope scope = place(part);
    scope.camera_sigmas = by_itself.camera_sigmas;
    if (Result<> added = take_instruments(part, scope); !added) return tl::unexpected(added.error());
    if (result_.georeferenced) {
      COLLINEA_TRY(result_.adjusted, tie_to_ground(part, scope));
    } else {
      COLLINEA_TRY(result_.adjusted, adjust_with_covariances(part, scope));
    }
    result_.calibration = calibration_used(result_.adjusted, scope, settled_options(part, options_).calibration);
    finish(part);
    add(additional_findings(result_.block, result_.adjusted));
    add(weak_cases(result_.block, setup_, pairs, result_.adjusted));
    return std::move(result_);
  }

  // What the lens does not describe: only now, since tie points are found without, and a few images do not tell it.
  std::map<CameraId, CameraSigmas> add_parameters(Reconstruction& part) {
    auto sigmas = add_additional(options_.additional, settled_options(part, options_).calibration, setup_.cameras);
    if (sigmas.empty())
      add(FindingCode::kAdditionalUncalibrated);
    else
      part.set_additional(setup_.cameras.at(sigmas.begin()->first).additional);
    return sigmas;
  }

  Result<Examined> adjust_with_covariances(Reconstruction& part, const AdjustScope& scope) const {
    ExamineOptions options{.adjust = settled_options(part, options_)};
    options.adjust.first_damping = kSettledDamping;
    return part.examine_all(options, scope, run_);
  }

  // Hardly anything but tie points took part: their sigma is what they show among each other. The loss sets in where it
  // did.
  static void take_sigma(Reconstruction& part, double sigma0) {
    TieNoise noise = part.noise();
    noise.sigma_px *= sigma0;
    noise.loss_scale_sigmas /= std::max(sigma0, kLeastSigma0);
    part.set_noise(noise);
  }

  // Control whose columns are in the other order, put right; nothing where that leads far from the block's place.
  [[nodiscard]] std::optional<std::map<ControlId, ControlPoint>> with_exchanged_axes() const {
    constexpr double kFar_m = 1e5;
    const auto frame = world_frame(*setup_.georeference);
    if (!frame) return std::nullopt;
    auto control = setup_.control;
    for (auto& [id, point] : control) {
      std::swap(point.position_in_map.x(), point.position_in_map.y());
      std::swap(point.sigma_m.x(), point.sigma_m.y());
      std::swap(point.correlation[1], point.correlation[2]);
      point.position_in_world = frame->local_from_map(point.position_in_map);
      if (!(point.position_in_world.norm() < kFar_m)) return std::nullopt;
    }
    return control;
  }

  // Lever arms, shifts and attitudes, as far as the block has a place to which they can belong.
  Result<> take_instruments(const Reconstruction& part, AdjustScope& scope) {
    InstrumentOptions asked = options_.instruments;
    if (!result_.georeferenced || !scope.use_positions) {
      const bool of_positions = is_of_positions(asked);
      asked.lever_arm.reset();
      asked.position_shift = PositionShift::kNone;
      asked.position_drift = asked.time_offset = false;
      if (of_positions) add(FindingCode::kPositionsUnused);
    }
    if (!result_.georeferenced && asked.use_attitudes) {
      asked.use_attitudes = false;
      add(FindingCode::kAttitudesUnused);
    }
    if (asked.position_shift != PositionShift::kNone && !has_control(scope)) {
      asked.position_shift = PositionShift::kNone;
      asked.position_drift = false;
      add(FindingCode::kShiftUnused);
    }
    result_.instruments = asked;
    return add_instruments(part.block(), asked, scope);
  }

  // A surveyed point that is seen twice.
  [[nodiscard]] bool has_control(const AdjustScope& scope) const {
    std::map<ControlId, int> seen;
    for (const ControlObservation& one : setup_.control_observations) ++seen[one.point];
    return scope.use_control && std::any_of(seen.begin(), seen.end(), [&](const auto& point) {
             const ControlPoint& control = setup_.control.at(point.first);
             return point.second > 1 && control.role == ControlRole::kControl && control.sigma_m.allFinite();
           });
  }

  // Control against positions and points among each other.
  [[nodiscard]] ControlDiagnosis diagnose(const Block& block) const {
    ControlDiagnosis diagnosis = check_control(block, run_.seed);
    if (options_.instruments.position_shift != PositionShift::kNone) expect_shift(diagnosis);
    return diagnosis;
  }

  // What is wrong with control or positions is named and left out, for good.
  void examine(Block block) {
    ControlDiagnosis diagnosis = diagnose(block);
    if (diagnosis.axes_swapped)
      if (auto control = with_exchanged_axes()) {
        for (const Finding& finding : diagnosis.findings)
          if (finding.code == FindingCode::kControlAxesSwapped) {
            result_.findings.push_back(finding);
            add(FindingCode::kControlAxesExchanged);
          }
        block.control = setup_.control = *std::move(control);
        diagnosis = diagnose(block);
      }
    add(diagnosis.findings);
    result_.excluded_control = diagnosis.excluded_points;
    apply(diagnosis, setup_);
    if (diagnosis.axes_swapped) setup_.control_observations.clear();
  }

  // Rays to one control point that miss each other by many times their sigma were not measured as well as stated.
  void weigh_measurements(const Block& block) {
    double squares = 0, redundancy = 0, sigma_px = 0;
    for (const auto& [id, point] : block.control) {
      const std::vector<SightLine> lines = sight_lines(block, id);
      const auto met = intersect(lines);
      if (lines.size() < 2 || !met) continue;
      const double left = 2 * static_cast<double>(lines.size()) - 3;
      squares += met->sigma0 * met->sigma0 * left;
      redundancy += left;
    }
    const double factor = redundancy < kLeastRedundancy ? 0 : std::sqrt(squares / redundancy);
    if (factor < kControlMisfit) return;
    for (ControlObservation& seen : setup_.control_observations) sigma_px = std::max(sigma_px, seen.sigma_px *= factor);
    result_.sigma_factors[std::size_t(ObservationGroup::kControlImages)] = factor;
    add(FindingCode::kControlMeasurementSigma, {}, {{FigureName::kRatio, factor}, {FigureName::kSigmaPx, sigma_px}},
        {RemedyCode::kLookForMarks});
  }

  // Adjusts with positions and control. Coordinates of control that contradict the block, and themselves, by many times
  // their sigma cannot be as good as stated: they are given the sigma they show, and that is said.
  Result<Examined> tie_to_ground(Reconstruction& part, const AdjustScope& scope) {
    if (scope.use_control) weigh_measurements(part.block());
    COLLINEA_TRY(settle(part, scope, options_, false, run_));
    COLLINEA_TRY(Examined tied, adjust_with_covariances(part, scope));
    if (control_misfit(setup_, tied) < kControlMisfit) return tied;
    const bool is_unknown =
        result_.instruments.position_shift != PositionShift::kNone;  // then the adjustment has found it
    Eigen::Vector3d shift_m = is_unknown ? Eigen::Vector3d(0, 0, 0) : shift_positions(setup_, tied);
    ByKind<double> taken{1, 1};
    for (int round = 0; round < kControlRounds; ++round) {
      const auto doubt = next_doubt(setup_, tied, taken);
      if (!doubt) break;
      const auto [kind, factor] = *doubt;
      taken[kind] *= factor;
      for (auto& [id, point] : setup_.control)
        if (point.role == ControlRole::kControl)
          for (int axis = 0; axis < 3; ++axis)
            if (kind_of(axis) == kind) point.sigma_m[axis] *= factor;
      COLLINEA_TRY(tied, adjust_with_covariances(part, scope));
      if (!is_unknown) shift_m += shift_positions(setup_, tied);
    }
    result_.position_shift_m = shift_m;
    result_.sigma_factors[std::size_t(ObservationGroup::kControlPlan)] = taken[kPlan];
    result_.sigma_factors[std::size_t(ObservationGroup::kControlHeight)] = taken[kHeight];
    say_how_positions_were_shifted(shift_m);
    say_what_control_shows(taken);
    COLLINEA_TRY(settle(part, scope, options_, false, run_));
    return adjust_with_covariances(part, scope);
  }

  void say_how_positions_were_shifted(const Eigen::Vector3d& shift_m) {
    if (shift_m.isZero()) return;
    add(FindingCode::kPositionsShifted, {},
        {{FigureName::kEast, shift_m.x()}, {FigureName::kNorth, shift_m.y()}, {FigureName::kUp, shift_m.z()}});
  }

  void say_what_control_shows(const ByKind<double>& taken) {
    for (const ControlKind kind : {kPlan, kHeight}) {
      if (taken[kind] == 1) continue;
      double sigma_m = 0;
      for (const auto& [id, point] : setup_.control)
        for (int axis = 0; axis < 3; ++axis)
          if (point.role == ControlRole::kControl && kind_of(axis) == kind && std::isfinite(point.sigma_m[axis]))
            sigma_m = std::max(sigma_m, point.sigma_m[axis]);
      add(kind == kPlan ? FindingCode::kControlSigmaPlan : FindingCode::kControlSigmaHeight, {},
          {{FigureName::kRatio, taken[kind]}, {FigureName::kSigma, sigma_m}}, {RemedyCode::kLookForPoints});
    }
  }

  // Positions that do not tell the tilt must not change it: the attitudes do or, without any, it stays to two degrees.
  static std::map<ImageId, GivenVertical> kept_level(const Reconstruction& part) {
    auto verticals = verticals_by_attitude(part.block());
    if (!verticals.empty()) return verticals;
    const double sigma_rad = 2 / kDegrees * std::sqrt(static_cast<double>(part.poses().size()));
    for (const auto& [image, pose] : part.poses())
      verticals[image] = {pose.rotation * Eigen::Vector3d::UnitZ(), sigma_rad};
    return verticals;
  }

  // A model from elsewhere stays where it lies when that is the map, or when nothing here knows better.
  bool stays_as_given(const Reconstruction& part) {
    const bool in_map = setup_.georeference && (given_->in_world || lies_in_world(part.block()));
    const bool knows_better = setup_.georeference && !in_map && (options_.use_positions || options_.use_control);
    if (knows_better) return false;
    result_.georeferenced = in_map;
    result_.gauge = {.map = in_map ? setup_.georeference->crs : "", .given_by = given_->source};
    return true;
  }

  // Brings the part into the frame of control or positions, where there are enough of them.
  AdjustScope place(Reconstruction& part) {
    AdjustScope scope{.use_positions = options_.use_positions,
                      .use_control = options_.use_control,
                      .use_ground = options_.use_ground};
    if (setup_.georeference && scope.use_control) examine(part.block());
    if (given_ && stays_as_given(part)) {
      scope.use_positions &= result_.georeferenced;
      scope.use_control &= result_.georeferenced;
      scope.use_ground = scope.use_ground && (result_.georeferenced || scale_by_distances(part));
      if (scope.use_positions && turn_sigma_rad(part.block(), 1) > kWeakTurn_rad) scope.verticals = kept_level(part);
      return scope;
    }
    auto found =
        setup_.georeference ? datum(part.block(), scope.use_positions, scope.use_control, run_.seed) : std::nullopt;
    if (setup_.georeference && scope.use_positions && (!found || found->control.empty())) {
      const double turn_rad = found ? turn_sigma_rad(part.block(), found->world_from_block.scale) : kNoTurn_rad;
      if (turn_rad > kWeakTurn_rad && place_strip(part, scope)) return scope;
      if (turn_rad >= kNoTurn_rad && place_level(part, scope)) return scope;
      if (turn_rad >= kNoTurn_rad) found.reset();
    }
    if (!found) {
      scope.use_positions = scope.use_control = false;
      if (!given_) part.move_world(readable_gauge(part, setup_));
      if (given_) result_.gauge.given_by = given_->source;
      scope.use_ground = scope.use_ground && scale_by_distances(part);
      if (setup_.georeference) add(FindingCode::kLocalGauge);
      return scope;
    }
    part.move_world(found->world_from_block);
    in_datum_ = {found->control.begin(), found->control.end()};
    result_.georeferenced = true;
    const std::size_t positions = scope.use_positions ? count_positions(part.block()) : 0;
    result_.gauge = {.map = setup_.georeference->crs, .by_control = found->by_control, .positions = positions};
    return scope;
  }

  // A block without place gets at least its scale. Distances that contradict the others are left out, for good.
  bool scale_by_distances(Reconstruction& part) {
    const auto found = geodetic_scale(part.block());
    if (!found) return false;
    for (const std::size_t place : found->excluded) setup_.ground[place].role = ControlRole::kCheck;
    result_.excluded_geodetic.insert(found->excluded.begin(), found->excluded.end());
    add(found->findings);
    Similarity3 scaled;
    scaled.scale = found->scale;
    part.move_world(scaled);
    result_.metric = true;
    result_.gauge = {.given_by = given_ ? given_->source : "",
                     .distances = static_cast<std::uint64_t>(found->distances)};
    return true;
  }

  // Positions on one line: the turn about it is held by the attitudes, with their sigma.
  bool place_strip(Reconstruction& part, AdjustScope& scope) {
    const auto found = strip_datum(part.block());
    if (!found) return false;
    part.move_world(*found);
    scope.verticals = verticals_by_attitude(part.block());
    result_.georeferenced = true;
    result_.gauge = {.map = setup_.georeference->crs,
                     .positions = count_positions(part.block()),
                     .position_use = PositionUse::kOnLine};
    add(FindingCode::kPositionsOnLine, {}, {}, {RemedyCode::kAddStripOrControl});
    return true;
  }

  // Positions that tell no tilt, without heights or too close together: what is level comes from the pictures.
  bool place_level(Reconstruction& part, AdjustScope& scope) {
    const auto found = level_datum(part.block());
    if (!found) return false;
    part.move_world(found->world_from_block);
    scope.verticals = found->verticals;
    result_.georeferenced = true;
    result_.gauge = {.map = setup_.georeference->crs,
                     .positions = found->positions,
                     .position_use = found->heights ? PositionUse::kSpace : PositionUse::kPlan,
                     .level = found->level_by};
    add(finding_of_level(found->level_by), {},
        {{FigureName::kHeights, static_cast<double>(found->heights)},
         {FigureName::kSigmaAngle, found->level_sigma_rad * kDegrees},
         {FigureName::kSigmaScale, found->turn_sigma_rad},
         {FigureName::kSigmaAzimuth, found->turn_sigma_rad * kDegrees}},
        {RemedyCode::kGiveThreeControlPoints});
    result_.relative_heights = found->heights == 0;
    if (result_.relative_heights) add(FindingCode::kHeightsRelative);
    return true;
  }

  // Images that are neither in the block nor in another part.
  [[nodiscard]] std::vector<ImageId> left_alone() const {
    std::set<ImageId> taken;
    for (const auto& part : result_.other_parts) taken.insert(part.begin(), part.end());
    for (const auto& [image, pose] : oriented_images(result_.block)) taken.insert(image);
    std::vector<ImageId> alone;
    for (const auto& [image, data] : setup_.images)
      if (!taken.contains(image)) alone.push_back(image);
    return alone;
  }

  void finish(Reconstruction& part) {
    result_.metric |= result_.georeferenced;
    add(geodetic_findings(setup_, result_.adjusted, result_.excluded_geodetic));
    result_.block = part.block();
    add(instrument_findings(result_.adjusted));
    result_.alone = left_alone();
    result_.gsd_m = median_pixel_m(result_.block);
    for (const auto& other : result_.other_parts)
      add(FindingCode::kPartApart, {other.front(), other.back()},
          {{FigureName::kCount, static_cast<double>(other.size())}});
    if (!result_.alone.empty())
      add(FindingCode::kImagesAlone, {result_.alone.front()},
          {{FigureName::kCount, static_cast<double>(result_.alone.size())}});
  }

  void add(FindingCode code, std::vector<Subject> subjects = {}, std::vector<Figure> figures = {},
           std::vector<Remedy> remedies = {}) {
    result_.findings.push_back(finding_of(code, std::move(subjects), std::move(figures), std::move(remedies)));
  }
  void add(const std::vector<Finding>& findings) {
    result_.findings.insert(result_.findings.end(), findings.begin(), findings.end());
  }

  const KeypointSource& keypoints_;
  const PictureSource& pictures_;
  Block setup_;  ///< ours: the examination of control may take observations out
  const OrientOptions& options_;
  const Run& run_;
  const GivenOrientation* given_ = nullptr;  ///< nothing: the poses are found here
  std::set<ControlId> in_datum_;             ///< control that fixed the similarity to the map
  Orientation result_;
};

}  // namespace

Result<Orientation> orient(const Block& setup, std::span<const ImagePair> pairs, const KeypointSource& keypoints,
                           const OrientOptions& options, const Run& run, const PictureSource& pictures) {
  if (options.mode == OrientMode::kGlobal && !options.use_positions)
    return fail(Errc::kBadInput,
                "a block that begins all at once begins from the positions of its images, and these are not to be "
                "used: orient image after image",
                {"mode"_option, "use_positions"_option});
  if (Result<> valid = check_instruments(options.instruments, setup); !valid) return tl::unexpected(valid.error());
  return Orienter(setup, keypoints, pictures, options, run).orient(pairs);
}

Result<Orientation> orient_as_given(const Block& setup, std::span<const ImagePair> pairs,
                                    const KeypointSource& keypoints, const GivenOrientation& given,
                                    const OrientOptions& options, const Run& run, const PictureSource& pictures) {
  if (given.cam_from_world.empty()) return fail(Errc::kBadInput, given.source + " has no pose of any photograph");
  if (Result<> valid = check_instruments(options.instruments, setup); !valid) return tl::unexpected(valid.error());
  return Orienter(setup, keypoints, pictures, options, run).orient_from(given, pairs);
}

}  // namespace collinea
