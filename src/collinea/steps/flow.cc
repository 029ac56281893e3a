// SPDX-License-Identifier: Apache-2.0
#include "collinea/steps/flow.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "collinea/base/file.h"
#include "collinea/base/hash.h"
#include "collinea/base/memory.h"
#include "collinea/edit/read_work.h"
#include "collinea/project/cost.h"
#include "collinea/project/given_orientation.h"
#include "collinea/report/signed_files.h"
#include "collinea/report/step_words.h"
#include "collinea/steps/internal/edited_record.h"
#include "collinea/steps/internal/frame_list.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;

Error stopped() { return Error{Errc::kCancelled, "stopped; the same command goes on from here"}; }

struct StepRow {
  Step step;
  Result<StepOutput> (*work)(Project&, const std::string& inputs_hash);
  std::vector<Step> reads;            ///< earlier steps whose output it uses
  std::vector<const char*> products;  ///< files without which it is not done
  /// Further ones, which follow from what was asked and made; null: none.
  std::vector<std::string> (*more_products)(const Settings&, const StepOutcome&) = nullptr;
  /// A file among its options; null: none may be.
  std::optional<fs::path> (*given_file)(const Settings&) = nullptr;
  std::vector<const char*> reads_options = {};  ///< of other steps
  bool reads_setup = false;    ///< control, map and position sigmas too: all that import left in the store
  bool reads_sources = false;  ///< what import was given, with the remarks on it
  bool reads_masks = false;    ///< of photographs
  bool reads_patches = false;  ///< of the orthophoto
  bool reads_points = false;   ///< which of the cloud people left
  bool reads_classes = false;  ///< that people gave the cloud

  [[nodiscard]] bool reads_work() const { return reads_masks || reads_patches || reads_points || reads_classes; }

  [[nodiscard]] std::string_view name() const { return word_of(step); }
};

constexpr const char* kCloud = "products/cloud.*";  // in the form asked for

std::vector<std::string> ply_asked_for(const Settings& settings, const StepOutcome&) {
  return settings.densify.ply ? std::vector<std::string>{"products/cloud.ply"} : std::vector<std::string>{};
}
std::vector<std::string> files_of_planes(const Settings&, const StepOutcome& outcome) {
  return frame_files(std::get<FramesRecord>(outcome));
}
std::optional<fs::path> given_seamlines(const Settings& settings) { return settings.ortho.seamlines; }
std::optional<fs::path> given_planes(const Settings& settings) {
  const fs::path* file = settings.frames.frames.get<fs::path>();
  return file ? std::optional(*file) : std::nullopt;
}

// The only place that knows the order of work.
const std::array<StepRow, std::size(kStepWords)>& steps() {
  static const std::array<StepRow, std::size(kStepWords)> all = {{
      {Step::kImport, import_step, {}, {}},
      {.step = Step::kDetect, .work = detect_step, .reads = {Step::kImport}, .products = {}, .reads_masks = true},
      {Step::kMatch, match_step, {Step::kImport, Step::kDetect}, {}},
      {.step = Step::kOrient,
       .work = orient_step,
       .reads = {Step::kImport, Step::kMatch},
       .products = {},
       .reads_setup = true},
      {.step = Step::kAdjust,
       .work = adjust_step,
       .reads = {Step::kOrient},
       .products = {"adjustment/adjustment.html"},
       .reads_setup = true},
      {.step = Step::kDensify,
       .work = densify_step,
       .reads = {Step::kAdjust},
       .products = {kCloud},
       .more_products = ply_asked_for,
       .reads_masks = true},
      {.step = Step::kSurface,
       .work = surface_step,
       .reads = {Step::kAdjust, Step::kDensify},
       .products = {"products/dsm.tif", "products/dsm_sigma.tif", "products/dsm_state.tif", "products/dsm_count.tif",
                    "products/dsm_sigma_relative.tif", "products/dsm_hillshade.tif"},
       .reads_points = true},
      {.step = Step::kTerrain,
       .work = terrain_step,
       .reads = {Step::kAdjust, Step::kSurface},
       .products = {"products/dtm.tif", "products/dtm_sigma.tif", "products/dtm_state.tif",
                    "products/dtm_sigma_relative.tif", "products/dtm_hillshade.tif"},
       .reads_classes = true},
      {.step = Step::kOrtho,
       .work = ortho_step,
       .reads = {Step::kAdjust, Step::kSurface, Step::kTerrain},
       .products = {"products/ortho.tif", "products/ortho_source.tif", "products/seamlines.gpkg"},
       .given_file = given_seamlines,
       .reads_masks = true,
       .reads_patches = true},
      {.step = Step::kFrames,
       .work = frames_step,
       .reads = {Step::kAdjust, Step::kDensify},
       .products = {},
       .more_products = files_of_planes,
       .given_file = given_planes,
       .reads_options = {"ortho"},
       .reads_masks = true,
       .reads_points = true},
      {.step = Step::kReport,
       .work = report_step,
       .reads = {Step::kImport, Step::kDetect, Step::kMatch, Step::kOrient, Step::kAdjust, Step::kDensify,
                 Step::kSurface, Step::kTerrain, Step::kOrtho, Step::kFrames},
       .products = {"report/report.html", kHashesFile},
       .reads_setup = true,
       .reads_sources = true},
  }};
  return all;
}

// What a step reads of people's work beside control; empty: nothing.
Result<std::string> work_text(const Project& project, const StepRow& step) {
  std::string text;
  if (!step.reads_work()) return text;
  COLLINEA_TRY(const EditedWork work, read_work(project));
  if (step.reads_masks) text += masks_of(work).text();
  if (step.reads_patches) text += patches_text(work);
  if (step.reads_points) text += text_of(regions_of_surface(work.regions));
  if (step.reads_classes) text += text_of(regions_of_classes(work.regions));
  return text;
}

Result<std::string> inputs_hash_of(const Project& project, const StepRow& step) {
  Hash hash;
  hash.add(COLLINEA_VERSION).add(step.name()).add(options_text(project.settings, std::string(step.name())));
  if (step.reads.empty()) hash.add(fingerprint_of_sources(project.settings.photos, project.settings.import));
  if (const auto& given = project.settings.orient.orientation; given && step.step == Step::kOrient)
    hash.add(fingerprint_of_orientation(*given));
  for (const char* other : step.reads_options) hash.add(options_text(project.settings, other));
  if (const auto given = step.given_file ? step.given_file(project.settings) : std::nullopt)
    hash.add(std::uint64_t{hash_of_file(*given).value_or(0)});
  for (const Step earlier : step.reads) {
    COLLINEA_TRY(const auto record, project.store.read_step(std::string(word_of(earlier))));
    COLLINEA_CHECK(record.has_value());
    hash.add(record->output_hash);
    if (step.reads_sources && earlier == Step::kImport) hash.add(record->inputs_hash);
  }
  if (step.reads_setup) {
    COLLINEA_TRY(const std::uint64_t setup, project.store.setup_hash());
    hash.add(setup);
  }
  COLLINEA_TRY(const std::string work, work_text(project, step));
  if (!work.empty()) hash.add(work);
  return hash.hex();
}

fs::path product_path(const Project& project, const char* product) {
  return product == std::string_view(kCloud) ? project.cloud() : project.folder / product;
}

bool products_exist(const Project& project, const StepRow& step, const StepRecord& record) {
  if (skipped_because(record.outcome)) return true;  // it left no product
  for (const char* product : step.products)
    if (!is_there(product_path(project, product))) return false;
  if (!step.more_products) return true;
  return std::ranges::all_of(step.more_products(project.settings, record.outcome),
                             [&](const std::string& product) { return is_there(project.folder / product); });
}

// What is recorded of the step. What another version of the program recorded counts as not done.
Result<std::optional<StepRecord>> earlier_record(Project& project, const StepRow& step) {
  auto before = project.store.read_step(std::string(step.name()));
  if (before || before.error().code != Errc::kUnsupported) return before;
  COLLINEA_TRY(project.store.erase_step(std::string(step.name())));
  return std::nullopt;
}

// What people changed since, where a step at work kept them from the database.
Result<> take_edits(Project& project, Journal& journal) {
  COLLINEA_TRY(std::vector<UnfitEdit> unfit, apply_edits(project.store, journal));
  for (const UnfitEdit& edit : unfit)
    project.run.say(fmt::format("note: edit {} is left out: {}: {}", edit.number, edit.command, edit.why.message));
  return {};
}

template <class... Kinds>
bool is_of(const Edit& edit) {
  return (std::holds_alternative<Kinds>(edit) || ...);
}

// Edits that came while a step was at work may have been seen by it, or not: it counts as made of other inputs, and as
// another result for the steps behind it, also where they were undone since.
Result<bool> was_edited(const Project& project, const StepRow& step, std::uint64_t last_edit) {
  if (!step.reads_setup && !step.reads_work()) return false;
  Journal journal(project.folder);
  COLLINEA_TRY(journal.refresh());
  for (const EditEntry& entry : journal.history().entries()) {
    if (entry.number <= last_edit) continue;
    const Edit& edit = entry.target > 0 ? journal.history().at(entry.target).edit : entry.edit;
    if (step.reads_setup && !point_of(edit).empty()) return true;
    if (step.reads_masks && is_of<MaskImage, UnmaskImage>(edit)) return true;
    if (step.reads_patches && is_of<PatchSeams, UnpatchSeams>(edit)) return true;
    if (step.reads_points && is_of<ClassifyCloud, CutCloud, CropCloud>(edit)) return true;
    if (step.reads_classes && is_of<ClassifyCloud>(edit)) return true;
  }
  return false;
}

Result<> do_step(Project& project, const StepRow& step, Journal& journal) {
  COLLINEA_TRY(take_edits(project, journal));
  const std::uint64_t last_edit = journal.number();
  COLLINEA_TRY(const std::string inputs_hash, inputs_hash_of(project, step));
  COLLINEA_TRY(const auto before, earlier_record(project, step));
  if (before && before->inputs_hash == inputs_hash && products_exist(project, step, *before)) {
    project.run.say(fmt::format("{:<8} up to date", step.name()));
    return step.step == Step::kImport ? renew_import_record(project, journal.history()) : Result<>{};
  }
  if (before) COLLINEA_TRY(project.store.erase_step(std::string(step.name())));
  give_back_freed_memory();  // of the steps before
  const CostMeter cost;
  project.run.report(step.name(), 0);
  COLLINEA_TRY(const StepOutput output, step.work(project, inputs_hash).map_error([&](Error error) {
    if (error.code == Errc::kCancelled) error = stopped();
    return with_advice(std::move(error), project.folder).within(step.name());
  }));
  if (project.run.stopped()) return tl::unexpected(stopped().within(step.name()));
  project.run.report(step.name(), 1);
  if (skipped_because(output.outcome))
    for (const char* product : step.products) COLLINEA_TRY(remove_file(product_path(project, product)));
  COLLINEA_CHECK(step_of(output.outcome) == step.name());
  COLLINEA_TRY(const bool edited, was_edited(project, step, last_edit));
  const std::string meanwhile = edited ? " edited" : "";
  const StepRecord record{inputs_hash + meanwhile, output.output_hash + meanwhile, cost.seconds(),
                          cost.cpu_seconds(),      cost.peak_memory_bytes(),       output.outcome};
  COLLINEA_TRY(project.store.write_step(record));
  project.run.say(fmt::format("{:<8} {} ({:.1f} s, {:.1f} CPU-s, {:.0f} MB)", step.name(), summary_of(record.outcome),
                              record.seconds, record.cpu_seconds, record.peak_memory_bytes / 1e6));
  return {};
}

}  // namespace

Result<Step> step_named(std::string_view name) {
  if (const auto step = from_word<Step>(name)) return *step;
  std::string known;
  for (const Word<Step>& step : kStepWords) known += (known.empty() ? "" : ", ") + std::string(step.word);
  return fail(Errc::kBadInput, "no step is called \"" + std::string(name) + "\": choose one of " + known);
}

Result<> record_done(Project& project, const StepOutput& output) {
  const std::string_view name = step_of(output.outcome);
  const StepRow& step =
      *std::find_if(steps().begin(), steps().end(), [&](const StepRow& s) { return name == word_of(s.step); });
  COLLINEA_TRY(const std::string inputs_hash, inputs_hash_of(project, step));
  return project.store.write_step({inputs_hash, output.output_hash, 0, 0, 0, output.outcome});
}

Result<> bring_up_to(Project& project, Step last) {
  COLLINEA_CHECK(is_in_order(steps(), std::size(kStepWords), &StepRow::step));
  Journal journal(project.folder);
  for (const StepRow& step : steps()) {
    COLLINEA_TRY(do_step(project, step, journal));
    if (last == step.step) break;
  }
  return {};
}

}  // namespace collinea
