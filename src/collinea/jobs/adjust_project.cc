// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/adjust_project.h"
#include "collinea/report/value_words.h"
#include "collinea/report/write_adjustment.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <optional>
#include <set>

#include "collinea/adjust/refraction.h"
#include "collinea/base/file.h"
#include "collinea/io/adjustment_file.h"
#include "collinea/io/dbat_script.h"
#include "collinea/io/photomodeler.h"
#include "collinea/io/text.h"
#include "collinea/jobs/internal/adjusted_report.h"
#include "collinea/orient/additional.h"
#include "collinea/orient/approximate.h"
#include "collinea/quality/control_check.h"

namespace collinea {
namespace {

Result<OrientationRecord> orientation_of(const Project& project) {
  return project.store.read_outcome<OrientationRecord>().map_error([&](Error error) {
    return error.code == Errc::kNotFound
               ? Error{error.code, "the block is not oriented yet: collinea orient " + project.folder.string()}
               : error;
  });
}

// As orientation calibrated them. Where it fixed the poses of another program it also keeps what came with them.
Calibration calibration_of(const OrientationRecord& orientation) {
  return orientation.holds_given_poses ? Calibration::kNone : orientation.calibration.parameters;
}

// What orientation did without, or shall be done without, is compared all the same.
void choose_geodetic(Block& block, const OrientationRecord& orientation, bool use_geodetic) {
  std::set<std::size_t> used;
  for (const GeodeticDifference& one : orientation.geodetic)
    if (one.used) used.insert(one.observation);
  for (std::size_t i = 0; i < block.geodetic.size(); ++i)
    if (!use_geodetic || !used.contains(i)) block.geodetic[i].role = ControlRole::kCheck;
}

void change_instruments(const AdjustProjectOptions& asked, InstrumentOptions& instruments) {
  assign_fields(asked.instruments, instruments,
                [&](std::string_view name) { return asked.changed_instruments.contains(name); });
}

// As orientation used them, and what is asked otherwise.
InstrumentOptions instruments_of(const OrientationRecord& orientation, const AdjustProjectOptions& asked) {
  InstrumentOptions instruments = orientation.instruments;
  change_instruments(asked, instruments);
  return instruments;
}

ExamineOptions options_of(const AdjustProjectOptions& asked, Calibration calibration) {
  ExamineOptions options;
  options.adjust.calibration = calibration;
  options.adjust.loss = options.adjust.position_loss = asked.loss;
  options.adjust.loss_scale_sigmas = asked.loss_scale_sigmas;
  options.reliability = options.point_covariances = true;
  options.test = asked.tests;
  // What is signed is iterated until a step is a thousandth of the standard deviations; that is a step or two more.
  options.adjust.relative_cost_change = 1e-12;
  options.adjust.step_sigmas = 1e-3;
  return options;
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

/// All that is needed to adjust and to report.
struct Task {
  std::string title;
  Block block;
  AdjustScope scope;
  ExamineOptions options;
};

std::vector<std::string> words_in(const std::string& list) {
  std::vector<std::string> words;
  for (const std::string_view field : fields_of(list, ','))
    if (!trimmed(field).empty()) words.emplace_back(trimmed(field));
  return words;
}

// Gives the cameras the additional set that was asked for, free or fixed. A camera with another set begins at zero.
Result<> set_additional(const AdjustProjectOptions& asked, Task& task, const Run& run) {
  const std::optional<AdditionalSet>& wanted = asked.additional;
  const std::vector<std::string> fixed = words_in(asked.additional_fixed);
  std::set<std::string> instead;
  bool any = false;
  for (auto& [id, camera] : task.block.cameras) {
    const auto own = task.scope.camera_sigmas.find(id);
    Camera& first = task.scope.first_cameras.try_emplace(id, camera).first->second;
    if (wanted)
      for (Camera* one : {&camera, &first}) {
        if (one->additional != *wanted) std::fill(one->params.begin() + Camera::kParams, one->params.end(), 0.0);
        one->additional = *wanted;
      }
    else
      first.additional = camera.additional;  // found by orient, around zero
    if (camera.additional == AdditionalSet::kNone) continue;
    any = true;
    if (own != task.scope.camera_sigmas.end() && !wanted && fixed.empty()) continue;
    CameraSigmas sigmas{};  // a camera that was given stays as it is beneath them
    if (own != task.scope.camera_sigmas.end())
      sigmas = own->second;
    else if (camera.prior.calibrate)
      sigmas = calibration_sigmas(task.options.adjust.calibration, first);
    const auto both = with_additional(sigmas, first, fixed);
    if (!both)
      return fail(Errc::kBadInput,
                  "additional_fixed = \"" + asked.additional_fixed + "\": the " +
                      std::to_string(count_of(camera.additional)) + " parameters of " +
                      std::string(kAdditionalNames[std::size_t(camera.additional)]) + " are a1 to a" +
                      std::to_string(count_of(camera.additional)),
                  {"additional_fixed"_option});
    for (int k = 0; k < Camera::kParams; ++k)
      if (sigmas[std::size_t(k)] > 0 && (*both)[std::size_t(k)] == 0) instead.insert(param_name(k));
    task.scope.camera_sigmas[id] = *both;
  }
  if (!fixed.empty() && !any)
    return fail(Errc::kBadInput, "additional parameters are to be fixed, but no camera has any",
                {"additional_fixed"_option, "additional"_option});
  if (!instead.empty()) {
    std::string names;
    for (const std::string& one : instead) names += (names.empty() ? "" : ", ") + one;
    run.say("note: fixed, because the additional parameters say the same: " + names);
  }
  return {};
}

Result<Task> task_of(const Project& project, const AdjustProjectOptions& asked) {
  if (Result<> valid = validate(asked); !valid) return tl::unexpected(std::move(valid).error().within("adjust"));
  COLLINEA_TRY(const OrientationRecord orientation, orientation_of(project));
  COLLINEA_TRY(const Block setup, project.store.read_setup());
  Task task;
  COLLINEA_TRY(task.block, project.store.read_block());
  task.scope = {.first_cameras = setup.cameras,
                .use_positions = asked.use_positions && orientation.position_rms_m.has_value(),
                .use_control = asked.use_control && orientation.control_rmse_m.has_value()};
  const InstrumentOptions instruments = instruments_of(orientation, asked);
  if (task.scope.use_positions && task.scope.use_control) {
    ControlDiagnosis diagnosis = check_control(task.block, project.settings.seed);
    if (instruments.position_shift != PositionShift::kNone) expect_shift(diagnosis);
    apply(diagnosis, task.block);
  }
  if (asked.snoop) task.block.control_observations = setup.control_observations;  // those that orient rejected too
  if (task.scope.use_control && !asked.given_sigmas)
    judge_as_orient_did(orientation, instruments.position_shift == PositionShift::kNone, task.block, project.run);
  choose_geodetic(task.block, orientation, asked.use_geodetic);
  if (Result<> known = add_instruments(task.block, instruments, task.scope); !known)
    return tl::unexpected(known.error());
  task.options = options_of(asked, asked.calibration ? *asked.calibration : calibration_of(orientation));
  if (Result<> added = set_additional(asked, task, project.run); !added) return tl::unexpected(added.error());
  std::error_code error;
  task.title = std::filesystem::absolute(project.folder, error).lexically_normal().filename().string();
  return task;
}

Result<> correct_rays(const AdjustProjectOptions& asked, Block& block, const Run& run) {
  if (!asked.refraction) return {};
  COLLINEA_TRY(const Refracted done, correct_refraction(block));
  run.say(fmt::format("refraction: {} measurements corrected by up to {:.3f} px{}", done.corrected, done.largest_px,
                      done.left == 0 ? "" : fmt::format("; {} left, more than 75 degrees from the nadir", done.left)));
  return {};
}

Result<AdjustmentReport> adjust_task(Task task, const AdjustProjectOptions& asked, const std::filesystem::path& folder,
                                     const Run& run) {
  if (Result<> corrected = correct_rays(asked, task.block, run); !corrected) return tl::unexpected(corrected.error());
  COLLINEA_TRY(AdjustmentReport report, adjusted_report(std::move(task.block), task.scope, task.options, asked, run));
  report.title = task.title;
  COLLINEA_TRY(write_adjustment(report, folder));
  return report;
}

// Only what takes part: nothing of an image that orientation left out.
AdjustmentFile file_of(const Task& task) {
  AdjustmentFile file;
  file.block = task.block;
  Block& block = file.block;
  std::erase_if(block.images, [&](const auto& image) { return !is_oriented(block, image.first); });
  const auto unknown = [&](const auto& seen) { return !block.images.contains(seen.image); };
  std::erase_if(block.control_observations, unknown);
  std::erase_if(block.observations,
                [&](const Observation& seen) { return unknown(seen) || !block.points.contains(seen.point); });
  if (!task.scope.use_positions)
    for (auto& [id, image] : block.images) image.position.reset();
  if (!task.scope.use_control)
    for (auto& [id, control] : block.control) control.role = ControlRole::kCheck;
  file.instruments = task.scope;
  const auto not_there = [&](const auto& one) { return !block.images.contains(one.first); };
  std::erase_if(file.instruments.attitudes, not_there);
  std::erase_if(file.instruments.velocity_m_s, not_there);
  for (PositionTrack& track : file.instruments.position_tracks) std::erase_if(track.time, not_there);
  for (const auto& [id, camera] : block.cameras) {
    const auto first = task.scope.first_cameras.find(id);
    const Camera& given = first == task.scope.first_cameras.end() ? camera : first->second;
    file.given_cameras[id] = given;
    const auto own = task.scope.camera_sigmas.find(id);
    file.camera_sigmas[id] = own != task.scope.camera_sigmas.end() ? own->second
                             : camera.prior.calibrate ? calibration_sigmas(task.options.adjust.calibration, given)
                                                      : CameraSigmas{};
  }
  return file;
}

Result<AdjustmentFile> read_adjustment(const std::filesystem::path& path) {
  COLLINEA_TRY(const std::string text, read_file(path));
  if (is_dbat_script(text)) return read_dbat_script(path);
  const auto parse = !is_adjustment_file(text) && is_photomodeler(text) ? parse_photomodeler : parse_adjustment_file;
  return parse(text).map_error([&](Error e) { return std::move(e).within(path.string()); });
}

template <class Id>
std::string names(const std::vector<Id>& ids, const auto& name_of) {
  constexpr std::size_t kShown = 5;
  std::string text;
  for (std::size_t i = 0; i < std::min(ids.size(), kShown); ++i) text += (i > 0 ? ", " : "") + name_of(ids[i]);
  return ids.size() > kShown ? text + fmt::format(" and {} more", ids.size() - kShown) : text;
}

Result<> complete(Block& block, const Run& run) {
  COLLINEA_TRY(const Approximation found, approximate(block, run.seed));
  if (!found.resected.empty() || found.intersected > 0)
    run.say(fmt::format("approximate values: {} images resected, {} points intersected", found.resected.size(),
                        found.intersected));
  if (!found.without_pose.empty())
    run.say("note: no approximate pose, and fewer than four known points to find one: " +
            names(found.without_pose, [&](ImageId id) { return block.images.at(id).file; }) +
            "; left out. Give a line pose, or measure more points there");
  if (!found.without_position.empty())
    run.say("note: seen in fewer than two oriented images, or along nearly the same line: tie points " +
            names(found.without_position, [](PointId id) { return std::to_string(id.value); }) + "; left out");
  return {};
}

// Those of the file, but for what is asked otherwise.
Result<> add_instruments_of_file(AdjustmentFile& file, const AdjustProjectOptions& asked, AdjustScope& scope) {
  Instruments& given = file.instruments;
  const bool is_shift_changed = asked.changed_instruments.contains("position_shift");
  InstrumentOptions options;
  options.time_offset = !given.time_offset_sigma_s.empty();
  options.use_attitudes = !given.attitudes.empty();
  change_instruments(asked, options);
  if (options.lever_arm) given.lever_arms.clear();
  if (is_shift_changed) given.position_tracks.clear();
  if (!options.time_offset) given.time_offset_sigma_s.clear();
  if (!options.use_attitudes) given.attitudes.clear();
  options.time_offset &= given.time_offset_sigma_s.empty();
  options.use_attitudes &= given.attitudes.empty();
  static_cast<Instruments&>(scope) = std::move(given);
  return add_instruments(file.block, options, scope);
}

void set_calibration(const std::optional<Calibration>& asked, const AdjustmentFile& file, AdjustScope& scope) {
  scope.camera_sigmas = file.camera_sigmas;
  if (!asked) return;
  for (auto& [id, sigmas] : scope.camera_sigmas) {
    Camera camera = file.given_cameras.at(id);
    camera.prior.sigma_f_px = 1;
    const CameraSigmas named = calibration_sigmas(*asked, camera);
    for (std::size_t k = 0; k < sigmas.size(); ++k)
      sigmas[k] = named[k] == 0 ? 0 : sigmas[k] > 0 ? sigmas[k] : std::numeric_limits<double>::infinity();
  }
}

}  // namespace

Result<AdjustmentReport> adjust_project(const Project& project, const AdjustProjectOptions& asked) {
  COLLINEA_TRY(Task task, task_of(project, asked));
  AdjustProjectOptions of_matches = asked;
  of_matches.reject_mismatches = asked.reject_mismatches.value_or(true);
  return adjust_task(std::move(task), of_matches, project.folder / "adjustment", project.run);
}

Result<> export_adjustment(const Project& project, const AdjustProjectOptions& asked,
                           const std::filesystem::path& file) {
  COLLINEA_TRY(const Task task, task_of(project, asked));
  return write_adjustment_file(file, file_of(task));
}

Result<AdjustmentReport> adjust_file(const std::filesystem::path& path, const std::filesystem::path& folder,
                                     const AdjustProjectOptions& asked, const Run& run) {
  if (Result<> valid = validate(asked); !valid) return tl::unexpected(std::move(valid).error().within("adjust"));
  if (asked.given_sigmas)
    return fail(Errc::kBadInput,
                "a file states its sigmas itself, and these are taken: there is nothing that orient found control to "
                "be worth",
                {"given_sigmas"_option});
  COLLINEA_TRY(AdjustmentFile file, read_adjustment(path));
  if (Result<> completed = complete(file.block, run); !completed)
    return tl::unexpected(std::move(completed).error().within(path.string()));
  Task task{.title = path.stem().string(),
            .block = {},
            .scope = {.fixed_images = file.fixed_images,
                      .first_cameras = file.given_cameras,
                      .corrected_cameras = file.corrected_cameras,
                      .use_positions = asked.use_positions,
                      .use_control = asked.use_control},
            .options = options_of(asked, Calibration::kNone)};
  set_calibration(asked.calibration, file, task.scope);
  if (!asked.use_geodetic)
    for (GeodeticObservation& measured : file.block.geodetic) measured.role = ControlRole::kCheck;
  if (Result<> known = add_instruments_of_file(file, asked, task.scope); !known) return tl::unexpected(known.error());
  task.block = std::move(file.block);
  if (Result<> added = set_additional(asked, task, run); !added) return tl::unexpected(added.error());
  return adjust_task(std::move(task), asked, folder, run);
}

Result<> convert_adjustment(const std::filesystem::path& path, const std::filesystem::path& converted) {
  COLLINEA_TRY(const AdjustmentFile file, read_adjustment(path));
  return write_adjustment_file(converted, file);
}

}  // namespace collinea
