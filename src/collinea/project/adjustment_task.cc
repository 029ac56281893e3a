// SPDX-License-Identifier: Apache-2.0
#include "collinea/project/adjustment_task.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <string>

#include "collinea/orient/control_rejection.h"
#include "collinea/orient/instrument_options.h"
#include "collinea/quality/mark_check.h"
#include "collinea/report/value_words.h"

namespace collinea {
namespace {

Result<OrientationRecord> orientation_of(const Project& project) {
  return project.store.read_outcome<OrientationRecord>().map_error([&](Error error) {
    return error.code == Errc::kNotFound
               ? Error{error.code, "the block is not oriented yet: collinea orient " + project.folder.string()}
               : error;
  });
}

// What orientation did without, or shall be done without, is compared all the same.
void choose_geodetic(Block& block, const OrientationRecord& orientation, bool use_geodetic) {
  const std::set<std::uint32_t> excluded(orientation.excluded_geodetic.begin(), orientation.excluded_geodetic.end());
  for (std::size_t i = 0; i < block.geodetic.size(); ++i)
    if (!use_geodetic || excluded.contains(static_cast<std::uint32_t>(i))) block.geodetic[i].role = ControlRole::kCheck;
}

// What orientation found control to be worth, and where it moved the positions.
void judge_as_orient_did(const OrientationRecord& orientation, bool shift_positions, Block& block, const Run& run) {
  const SigmaFactors factors = factors_of(orientation.sigma_factors);
  block = with_sigmas(block, factors);
  const Eigen::Vector3d shift_m = shift_positions ? orientation.position_shift_m : Eigen::Vector3d(0, 0, 0);
  if (!shift_m.isZero())
    for (auto& [id, image] : block.images)
      if (image.position) image.position->position_in_world += shift_m;
  if (const std::string found = judgement_words(factors, shift_m); !found.empty())
    run.say(fmt::format("note: as orientation found: {}; {} takes what was stated", found,
                        run.spelled("given_sigmas"_option)));
}

// Control and positions as they took part in orientation.
void take_control(const Project& project, const AdjustmentOptions& asked, const Block& setup,
                  const ProjectAdjustment& result, Block& block) {
  const bool shift_is_unknown = result.task.instruments.position_shift != PositionShift::kNone;
  const AdjustScope& scope = result.task.scope;
  if (scope.use_control) block = reject_wrong_control(block, block, shift_is_unknown, project.settings.seed).setup;
  if (asked.snoop.value_or(false)) {  // those that orient rejected too
    block.control_observations = setup.control_observations;
    correct_marks(result.orientation.findings, block);
    remove_marks_outside(block);
  }
  if (scope.use_control && !asked.given_sigmas)
    judge_as_orient_did(result.orientation, !shift_is_unknown, block, project.run);
}

// What the adjustment multiplied given sigmas by beyond orientation.
SigmaFactors factors_since(const OrientationRecord& orientation, const AdjustmentRecord& adjustment) {
  SigmaFactors factors = factors_of(adjustment.sigma_factors);
  const SigmaFactors before = factors_of(orientation.sigma_factors);
  for (std::size_t i = 0; i < factors.size(); ++i) factors[i] /= before[i];
  return factors;
}

void take_adjusted(const Block& adjusted, Block& block) {
  block.cameras = adjusted.cameras;
  block.poses = adjusted.poses;
  block.points = adjusted.points;
  block.observations = adjusted.observations;
  block.control_observations = adjusted.control_observations;
}

}  // namespace

ExamineOptions examine_options(const AdjustmentOptions& asked, Calibration calibration) {
  ExamineOptions options;
  options.adjust.calibration = calibration;
  options.adjust.loss = asked.loss.value_or(Loss::kHuber);
  options.adjust.position_loss = asked.position_loss.value_or(options.adjust.loss);
  options.adjust.loss_scale_sigmas = asked.loss_scale_sigmas;
  options.reliability = options.point_covariances = true;
  options.test = asked.tests;
  // What is signed is iterated until a step is a thousandth of the standard deviations; that is a step or two more.
  options.adjust.relative_cost_change = 1e-12;
  options.adjust.step_sigmas = 1e-3;
  return options;
}

std::optional<SnoopedKinds> snooped_kinds(const AdjustmentOptions& asked, std::optional<SnoopedKinds> by_default) {
  if (!asked.snoop.value_or(true)) return std::nullopt;
  if (asked.snoop_given) return SnoopedKinds::kGiven;
  return asked.snoop ? SnoopedKinds::kAll : by_default;
}

Result<ProjectAdjustment> adjustment_of(const Project& project, const AdjustmentOptions& asked) {
  if (Result<> valid = validate(asked); !valid) return tl::unexpected(std::move(valid).error().within("adjust"));
  ProjectAdjustment result;
  COLLINEA_TRY(result.orientation, orientation_of(project));
  const OrientationRecord& orientation = result.orientation;
  COLLINEA_TRY(const Block setup, project.store.read_setup());
  AdjustmentTask& task = result.task;
  COLLINEA_TRY(task.block, project.store.read_found());
  COLLINEA_TRY(set_deflection(asked, task.block));
  task.instruments = changed(orientation.instruments, asked.instruments);
  task.scope = {.first_cameras = setup.cameras,
                .use_positions = asked.use_positions && orientation.used_positions,
                .use_control = asked.use_control && orientation.used_control,
                .use_check_rays = asked.check_rays.value_or(false)};
  if (orientation.holds_given_poses)
    for (const auto& [image, pose] : oriented_images(task.block)) task.scope.fixed_images.insert(image);
  for (const ImageId image : orientation.excluded_positions) task.block.images.at(image).position.reset();
  take_control(project, asked, setup, result, task.block);
  choose_geodetic(task.block, orientation, asked.use_geodetic && !orientation.holds_given_poses);
  COLLINEA_TRY(add_instruments(task.block, task.instruments, task.scope));
  task.options = examine_options(asked, asked.calibration.value_or(orientation.calibration));
  if (!asked.loss) task.options.adjust.loss = Loss::kNone;
  COLLINEA_TRY(choose_datum(asked, task));
  task.reject_mismatches = asked.reject_mismatches;
  task.snoop = snooped_kinds(asked, SnoopedKinds::kGiven);
  COLLINEA_TRY(const std::vector<std::string> instead, set_additional(asked, task));
  if (const std::string note = fixed_instead_words(instead); !note.empty()) project.run.say("note: " + note);
  return result;
}

Result<ProjectAdjustment> adjustment_in_force(const Project& project, const Block& adjusted) {
  COLLINEA_TRY(const auto record, project.store.read_outcome<AdjustmentRecord>());
  COLLINEA_TRY(ProjectAdjustment result, adjustment_of(project, project.settings.adjust));
  AdjustmentTask& task = result.task;
  task.block = with_sigmas(task.block, factors_since(result.orientation, record));
  take_adjusted(adjusted, task.block);
  task.instruments = record.instruments;  // some may have been taken up
  static_cast<Instruments&>(task.scope) = {};
  COLLINEA_TRY(add_instruments(task.block, task.instruments, task.scope));
  return result;
}

Result<ProjectAdjustment> adjustment_with_marks(const Project& project) {
  COLLINEA_TRY(ProjectAdjustment begun, adjustment_of(project, project.settings.adjust));
  if (!project.settings.import.film.calibration) return begun;
  COLLINEA_TRY(const Block adjusted, project.store.read_block());
  auto ended = adjustment_in_force(project, adjusted);
  return ended || ended.error().code != Errc::kNotFound ? std::move(ended) : std::move(begun);
}

}  // namespace collinea
