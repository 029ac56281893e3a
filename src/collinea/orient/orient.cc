// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/orient.h"

#include <algorithm>
#include <set>
#include <utility>

#include "collinea/math/median.h"
#include "collinea/orient/additional.h"
#include "collinea/orient/internal/block_parts.h"
#include "collinea/orient/internal/control_adjustment.h"
#include "collinea/orient/internal/incremental.h"
#include "collinea/orient/internal/outweighing_positions.h"
#include "collinea/orient/internal/placement.h"
#include "collinea/orient/internal/usable_instruments.h"
#include "collinea/orient/internal/weak_cases.h"

namespace collinea {
namespace {

constexpr double kLeastSigma0 = 1e-3;  // of exact data
constexpr double kFewFit = 0.5;        // of the tie points: wrong matches alone are far fewer
constexpr int kGivenRounds = 2;        // points that fit appear in the first, those they outvoted go in the second

// What a block is measured in; refers to the arguments of orient().
struct Sources {
  std::span<const ImagePair> pairs;
  const KeypointSource& keypoints;
  const ImageSource& images;  // may be empty
};

// A block in a gauge of its own.
struct BegunBlock {
  Reconstruction part;
  bool in_world = false;                    // the positions of its images placed it
  const GivenOrientation* given = nullptr;  // its poses; nothing: they were found here
  Orientation result;                       // what is known of it so far: other parts, findings
};

void add(Orientation& result, const std::vector<Finding>& findings) {
  result.findings.insert(result.findings.end(), findings.begin(), findings.end());
}

void add(Orientation& result, FindingCode code, std::vector<Subject> subjects = {}, std::vector<Figure> figures = {},
         std::vector<Remedy> remedies = {}) {
  result.findings.push_back(finding_of(code, std::move(subjects), std::move(figures), std::move(remedies)));
}

// A part adjusted by its tie points.
struct SettledPart {
  std::map<CameraId, CameraSigmas> camera_sigmas;  // of cameras with additional parameters
  int gross_measurements = 0;                      // of tie points, rejected
  std::vector<Finding> findings;
};

// Additional parameters of every camera that is calibrated. Only of a settled part: tie points are found without them,
// and few images do not determine them.
void add_parameters(Reconstruction& part, const OrientOptions& options, SettledPart& settled) {
  Block setup = part.setup();
  settled.camera_sigmas = add_additional(options.additional, settled_options(part, options).calibration, setup.cameras);
  if (settled.camera_sigmas.empty())
    settled.findings.push_back(finding_of(FindingCode::kAdditionalUncalibrated));
  else
    part.set_additional(setup.cameras.at(settled.camera_sigmas.begin()->first).additional);
  part.set_setup(std::move(setup));
}

Result<> measure_again(Reconstruction& part, const Sources& sources, const Run& run) {
  const Block measured = part.block();
  COLLINEA_TRY(auto positions, remeasure(measured, sources.keypoints, sources.images, run));
  keep_apart(measured, positions);
  std::vector<std::optional<Reconstruction::MovedRay>> moved;
  for (const auto& one : positions)
    moved.push_back(one ? std::optional(Reconstruction::MovedRay{one->pixel, one->sigma_px()}) : std::nullopt);
  part.move_rays(measured, moved);
  return {};
}

// Where hardly anything but tie points took part, their sigma is what they show among each other. The loss sets in
// where it did.
void take_sigma(Reconstruction& part, double sigma0) {
  TieNoise noise = part.noise();
  noise.sigma_px *= sigma0;
  noise.anew_factor *= sigma0;
  noise.loss_scale_sigmas /= std::max(sigma0, kLeastSigma0);
  part.set_noise(noise);
}

// Adjustment by tie points until their number and their noise settle; again with additional parameters, and with what
// was measured again; then without loss and without gross errors. A part that lies in the world by its positions keeps
// them: without them a large block only sways.
Result<SettledPart> settle_alone(Reconstruction& part, bool in_world, const Sources& sources,
                                 const OrientOptions& options, const Run& run) {
  SettledPart result;
  AdjustScope scope{.use_positions = in_world && options.use_positions, .use_control = false, .use_geodetic = false};
  COLLINEA_TRY(Adjusted adjusted, settle(part, scope, options, true, run));
  if (options.additional != AdditionalSet::kNone) {
    add_parameters(part, options, result);
    scope.camera_sigmas = result.camera_sigmas;
    COLLINEA_TRY(adjusted, settle(part, scope, options, true, run));
  }
  if (options.remeasure && sources.images) {
    COLLINEA_TRY(measure_again(part, sources, run));
    COLLINEA_TRY(adjusted, settle(part, scope, options, true, run));
  }
  if (const auto shown = part.shown_noise()) part.set_noise(*shown);
  if (const auto gross = part.leave_out_gross(run)) {
    result.gross_measurements = *gross;
    COLLINEA_TRY(adjusted, settle(part, scope, options, false, run));
  }
  take_sigma(part, adjusted.sigma0);
  return result;
}

// Calibration in an adjustment, of the cameras that moved: what was free, by the rule of adjust().
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

void take(const Placement& placed, Orientation& result) {
  result.georeferenced = placed.georeferenced;
  result.metric = placed.metric || placed.georeferenced;
  result.relative_heights = placed.relative_heights;
  result.gauge = placed.gauge;
  result.excluded_control = placed.excluded_control;
  result.excluded_geodetic = placed.excluded_geodetic;
  add(result, placed.findings);
}

// All observations in a placed block. One that is not georeferenced has no control that could be worse than stated.
Result<ControlAdjustment> adjust_placed(Reconstruction& part, const AdjustScope& scope, const Orientation& placed,
                                        const OrientOptions& options, const Run& run) {
  const bool shift_is_unknown = placed.instruments.position_shift != PositionShift::kNone;
  if (placed.georeferenced) return adjust_with_control(part, scope, shift_is_unknown, options, run);
  ControlAdjustment result;
  COLLINEA_TRY(result.adjusted, adjust_settled(part, scope, options, run));
  return result;
}

double median_pixel_m(const Block& block) {
  std::vector<double> sizes;
  for (const Observation& seen : block.observations) {
    const double depth_m = (pose_of(block, seen.image) * block.points.at(seen.point).position_in_world).z();
    sizes.push_back(depth_m / block.camera_of(seen.image).focal_px());
  }
  return sizes.empty() ? 0 : median(sizes);
}

// Images that are neither in the block nor in another part.
std::vector<ImageId> images_alone(const Orientation& result) {
  std::set<ImageId> taken;
  for (const auto& part : result.other_parts) taken.insert(part.begin(), part.end());
  for (const auto& [image, pose] : oriented_images(result.block)) taken.insert(image);
  std::vector<ImageId> alone;
  for (const auto& [image, data] : result.block.images)
    if (!taken.contains(image)) alone.push_back(image);
  return alone;
}

// The block as a value, and what it does not contain.
void finish(const Reconstruction& part, Orientation& result) {
  result.block = part.block();
  result.alone = images_alone(result);
  result.gsd_m = median_pixel_m(result.block);
  for (const auto& other : result.other_parts)
    add(result, FindingCode::kPartApart, {other.front(), other.back()},
        {{FigureName::kCount, static_cast<double>(other.size())}});
  if (!result.alone.empty())
    add(result, FindingCode::kImagesAlone, {result.alone.front()},
        {{FigureName::kCount, static_cast<double>(result.alone.size())}});
}

// Positions that would outweigh all others take no part.
void leave_out_outweighing(Reconstruction& part, std::uint64_t seed, Orientation& result) {
  const OutweighingPositions found = outweighing_positions(part.block(), seed);
  if (found.images.empty()) return;
  Block setup = part.setup();
  for (const ImageId image : found.images) setup.images.at(image).position.reset();
  part.set_setup(std::move(setup));
  result.excluded_positions = found.images;
  add(result, found.findings);
}

// A begun block adjusted by itself, placed, adjusted with all observations and judged.
Result<Orientation> adjust_in_world(BegunBlock begun, const Sources& sources, const OrientOptions& options,
                                    const Run& run) {
  Reconstruction& part = begun.part;
  Orientation result = std::move(begun.result);
  if (part.setup().georeference && options.use_positions) leave_out_outweighing(part, run.seed, result);
  COLLINEA_TRY(const SettledPart settled, settle_alone(part, begun.in_world, sources, options, run));
  result.gross_measurements = settled.gross_measurements;
  add(result, settled.findings);

  Placement placed = set_datum(part, begun.given, options, run.seed);
  take(placed, result);
  AdjustScope& scope = placed.scope;
  scope.camera_sigmas = settled.camera_sigmas;
  const UsableInstruments usable = usable_instruments(options.instruments, part.setup(), scope, result.georeferenced);
  result.instruments = usable.options;
  add(result, usable.findings);
  COLLINEA_TRY(add_instruments(part.block(), usable.options, scope));

  COLLINEA_TRY(ControlAdjustment adjustment, adjust_placed(part, scope, result, options, run));
  result.adjusted = std::move(adjustment.adjusted);
  result.sigma_factors = adjustment.sigma_factors;
  result.position_shift_m = adjustment.position_shift_m;
  add(result, adjustment.findings);
  result.options = settled_options(part, options);
  result.calibration = calibration_used(result.adjusted, scope, result.options.calibration);
  result.scope = with_first_cameras(std::move(scope), part.setup().cameras);

  finish(part, result);
  add(result, weak_cases(result.block, sources.pairs));
  return result;
}

// A block whose poses stay: cameras that nobody gave and points are estimated on them.
Result<Orientation> keep_poses(BegunBlock begun, const OrientOptions& options, const Run& run) {
  Reconstruction& part = begun.part;
  Orientation result = std::move(begun.result);
  AdjustScope scope{.use_positions = false, .use_control = false, .use_geodetic = false};
  for (const auto& [image, pose] : part.poses()) scope.fixed_images.insert(image);
  AdjustOptions adjust = settled_options(part, options);
  if (!begun.given->cameras.empty()) adjust.calibration = Calibration::kNone;
  for (int round = 0; round < kGivenRounds; ++round) {
    COLLINEA_TRY(part.adjust_all(adjust, scope, run));
    part.filter(options.max_error_px, run);
    part.extend_all(run);
    if (const auto shown = part.shown_noise()) part.set_noise(*shown);
  }
  if (options.additional != AdditionalSet::kNone)
    add(result, FindingCode::kAdditionalFixed, {}, {}, {OptionName{"refine_orientation", "orient"}});
  // Poses that hardly a tie point fits stay all the same, but that is stated.
  std::vector<ImageId> loose;
  for (const auto& [image, pose] : part.poses())
    if (part.active_rays(image) < options.min_points) loose.push_back(image);
  if (!loose.empty())
    add(result, FindingCode::kLooseGiven, {loose.front()},
        {{FigureName::kLimit, static_cast<double>(options.min_points)},
         {FigureName::kCount, static_cast<double>(loose.size())}});

  const Placement placed = set_datum(part, begun.given, options, run.seed);
  take(placed, result);
  COLLINEA_TRY(result.adjusted, part.adjust_all(adjust, scope, run));
  result.options = adjust;
  result.calibration = calibration_used(result.adjusted, scope, adjust.calibration);
  result.scope = with_first_cameras(std::move(scope), part.setup().cameras);
  result.holds_given_poses = true;
  for (ControlDifference& control : result.adjusted.control) control.used |= placed.in_datum.contains(control.point);
  finish(part, result);
  return result;
}

// Points intersected with given poses. Errors: no point; stopped.
Result<BegunBlock> begin_as_given(Block setup, const GivenOrientation& given, const Sources& sources,
                                  const OrientOptions& options, const Run& run) {
  for (const auto& [id, camera] : given.cameras) setup.cameras.at(id) = camera;
  COLLINEA_TRY(Reconstruction part, Reconstruction::create(setup, sources.pairs, sources.keypoints, options));
  BegunBlock begun{.part = std::move(part), .given = &given};
  begun.part.start_from_poses(given.cam_from_world);
  begun.part.extend_all(run);
  if (run.stopped()) return fail(Errc::kCancelled, "stopped");
  if (begun.part.point_count() == 0)
    return fail(Errc::kIllPosed, "no tie point fits the poses of " + given.source +
                                     ": they are not of these photographs, or their cameras are wrong");
  const auto rays = begun.part.ray_count();
  if (static_cast<double>(rays.active) < kFewFit * static_cast<double>(rays.all))
    add(begun.result, FindingCode::kFewFitGiven, {Subject::file(given.source)},
        {{FigureName::kCount, static_cast<double>(rays.active)}, {FigureName::kOf, static_cast<double>(rays.all)}});
  return begun;
}

}  // namespace

Result<Orientation> orient(const Block& setup, std::span<const ImagePair> pairs, const KeypointSource& keypoints,
                           const OrientOptions& options, const Run& run, const ImageSource& images) {
  if (options.mode == OrientMode::kGlobal && !options.use_positions)
    return fail(Errc::kBadInput,
                "a block that begins all at once begins from the positions of its images, and these are not to be "
                "used: orient image after image",
                {"mode"_option, "use_positions"_option});
  COLLINEA_TRY(check_instruments(options.instruments, setup));
  COLLINEA_TRY(BlockParts parts, grow_parts(setup, pairs, keypoints, options, run));
  BegunBlock grown{.part = std::move(parts.largest), .in_world = parts.in_world};
  grown.result.other_parts = std::move(parts.others);
  return adjust_in_world(std::move(grown), {pairs, keypoints, images}, options, run);
}

Result<Orientation> orient_as_given(const Block& setup, std::span<const ImagePair> pairs,
                                    const KeypointSource& keypoints, const GivenOrientation& given,
                                    const OrientOptions& options, const Run& run, const ImageSource& images) {
  if (given.cam_from_world.empty()) return fail(Errc::kBadInput, given.source + " has no pose of any photograph");
  COLLINEA_TRY(check_instruments(options.instruments, setup));
  const Sources sources{pairs, keypoints, images};
  COLLINEA_TRY(BegunBlock begun, begin_as_given(setup, given, sources, options, run));
  if (options.refine_orientation) return adjust_in_world(std::move(begun), sources, options, run);
  return keep_poses(std::move(begun), options, run);
}

}  // namespace collinea
