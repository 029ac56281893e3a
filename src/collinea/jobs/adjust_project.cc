// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/adjust_project.h"
#include "collinea/report/value_words.h"
#include "collinea/report/write_adjustment.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <optional>

#include "collinea/base/file.h"
#include "collinea/io/adjustment_file.h"
#include "collinea/io/bingo.h"
#include "collinea/io/dbat_script.h"
#include "collinea/io/patb.h"
#include "collinea/io/photomodeler.h"
#include "collinea/jobs/internal/file_options.h"
#include "collinea/orient/approximate.h"
#include "collinea/orient/instrument_options.h"
#include "collinea/orient/mirrored.h"
#include "collinea/project/adjustment_task.h"
#include "collinea/quality/systematic_findings.h"
#include "collinea/report/finding_words.h"

namespace collinea {
namespace {

Result<AdjustmentReport> adjust_task(AdjustmentTask task, std::string title, const AdjustmentOptions& asked,
                                     const std::filesystem::path& folder, const Run& run) {
  AdjustmentReport report;
  COLLINEA_TRY(static_cast<Adjustment&>(report), adjust_block(std::move(task), asked, run));
  report.title = std::move(title);
  report.spelling = run.spelling;
  for (const std::string& note : notes_of(report)) run.say("note: " + note);
  for (const Finding& finding : report.taken_up) run.say("note: " + sentence_of(finding, report.block, run.spelling));
  for (const Finding& finding : systematic_findings(report.adjusted.systematics, report.block))
    run.say("note: " + sentence_of(finding, report.block, run.spelling));
  COLLINEA_TRY(write_adjustment(report, folder, run));
  return report;
}

// Only what takes part: nothing of an image that orientation left out.
AdjustmentFile file_of(const AdjustmentTask& task) {
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

Result<AdjustmentFile> measurements_in(const std::filesystem::path& path) {
  COLLINEA_TRY(const std::string text, read_file(path));
  if (is_dbat_script(text)) return read_dbat_script(path);
  const bool is_own = is_adjustment_file(text), is_exported = !is_own && is_photomodeler(text);
  if (!is_own && !is_exported) {
    if (is_bingo(text, is_there(path.parent_path() / "geoin.dat"))) return read_bingo(path);
    if (is_patb(text)) return read_patb(path);
  }
  const auto parse = is_exported ? parse_photomodeler : parse_adjustment_file;
  return parse(text).map_error([&](Error e) { return std::move(e).within(path.string()); });
}

template <class Id>
std::string names(const std::vector<Id>& ids, const auto& name_of) {
  constexpr std::size_t kShown = 5;
  std::string text;
  for (std::size_t i = 0; i < std::min(ids.size(), kShown); ++i) text += (i > 0 ? ", " : "") + name_of(ids[i]);
  return ids.size() > kShown ? text + fmt::format(" and {} more", ids.size() - kShown) : text;
}

Result<> complete(Block& block, RobustStart start, const Run& run) {
  for (const Finding& finding : mirrored_measurements(block, run.seed))
    run.say("note: " + sentence_of(finding, block, run.spelling));
  COLLINEA_TRY(const Approximation found, approximate(block, run.seed, start));
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

// Those of the file, but for what is asked otherwise. What takes part is not taken up once more.
Result<> add_instruments_of_file(AdjustmentFile& file, const InstrumentChanges& asked, AdjustmentTask& task) {
  Instruments& given = file.instruments;
  InstrumentOptions options;
  options.time_offset = !given.time_offset_sigma_s.empty();
  options.use_attitudes = !given.attitudes.empty();
  options = changed(options, asked);
  if (options.lever_arm) given.lever_arms.clear();
  if (asked.position_shift) given.position_tracks.clear();
  if (!options.time_offset) given.time_offset_sigma_s.clear();
  if (!options.use_attitudes) given.attitudes.clear();
  options.time_offset &= given.time_offset_sigma_s.empty();
  options.use_attitudes &= given.attitudes.empty();
  task.instruments = options;
  task.instruments.time_offset |= !given.time_offset_sigma_s.empty();
  if (!given.lever_arms.empty() && !has_lever_arm(options)) task.instruments.lever_arm = LeverArmOption("estimate");
  if (!given.position_tracks.empty()) task.instruments.position_shift = PositionShift::kBlock;
  static_cast<Instruments&>(task.scope) = std::move(given);
  return add_instruments(file.block, options, task.scope);
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

Result<> check_for_a_file(const AdjustmentOptions& asked) {
  if (Result<> valid = validate(asked); !valid) return tl::unexpected(std::move(valid).error().within("adjust"));
  if (!asked.given_sigmas) return {};
  return fail(Errc::kBadInput,
              "a file states its sigmas itself, and these are taken: there is nothing that orient found control to "
              "be worth",
              {"given_sigmas"_option});
}

}  // namespace

Result<AdjustmentReport> try_adjustment(const Project& project, const AdjustmentOptions& asked,
                                        const std::filesystem::path& folder) {
  COLLINEA_TRY(ProjectAdjustment begun, adjustment_of(project, asked));
  return adjust_task(std::move(begun.task), title_of(project), asked, folder, project.run);
}

Result<> export_adjustment(const Project& project, const AdjustmentOptions& asked, const std::filesystem::path& file) {
  COLLINEA_TRY(const ProjectAdjustment begun, adjustment_of(project, asked));
  AdjustmentFile written = file_of(begun.task);
  written.options = options_of(begun.task, asked);
  return write_adjustment_file(file, written);
}

Result<FileAdjustment> read_adjustment(const std::filesystem::path& path) {
  FileAdjustment given{.path = path, .file = {}, .options = {}};
  COLLINEA_TRY(given.file, measurements_in(path));
  COLLINEA_TRY(given.options,
               options_in(given.file.options).map_error([&](Error e) { return std::move(e).within(path.string()); }));
  return given;
}

Result<AdjustmentReport> adjust_file(FileAdjustment given, const std::filesystem::path& folder, const Run& run) {
  auto& [path, file, asked] = given;
  COLLINEA_TRY(check_for_a_file(asked));
  COLLINEA_TRY(set_deflection(asked, file.block));
  if (Result<> completed = complete(file.block, asked.start, run); !completed)
    return tl::unexpected(std::move(completed).error().within(path.string()));
  AdjustmentTask task{.block = {},
                      .scope = {.fixed_images = file.fixed_images,
                                .first_cameras = file.given_cameras,
                                .corrected_cameras = file.corrected_cameras,
                                .use_positions = asked.use_positions,
                                .use_control = asked.use_control,
                                .use_check_rays = asked.check_rays.value_or(false)},
                      .options = examine_options(asked, Calibration::kNone),
                      .reject_mismatches = asked.reject_mismatches,
                      .snoop = snooped_kinds(asked, std::nullopt)};
  set_calibration(asked.calibration, file, task.scope);
  if (!asked.use_geodetic)
    for (GeodeticObservation& measured : file.block.geodetic) measured.role = ControlRole::kCheck;
  COLLINEA_TRY(add_instruments_of_file(file, asked.instruments, task));
  task.block = std::move(file.block);
  COLLINEA_TRY(choose_datum(asked, task));
  COLLINEA_TRY(const std::vector<std::string> instead, set_additional(asked, task));
  if (const std::string note = fixed_instead_words(instead); !note.empty()) run.say("note: " + note);
  return adjust_task(std::move(task), path.stem().string(), asked, folder, run);
}

Result<AdjustmentReport> adjust_file(const std::filesystem::path& path, const std::filesystem::path& folder,
                                     const AdjustmentOptions& asked, const Run& run) {
  COLLINEA_TRY(check_for_a_file(asked));
  COLLINEA_TRY(FileAdjustment given, read_adjustment(path));
  given.options = asked;
  return adjust_file(std::move(given), folder, run);
}

Result<> convert_adjustment(const FileAdjustment& given, const std::filesystem::path& converted) {
  AdjustmentFile file = given.file;
  file.options = changed_options(given.options);
  return write_adjustment_file(converted, file);
}

}  // namespace collinea
