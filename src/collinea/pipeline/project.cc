// SPDX-License-Identifier: Apache-2.0
#include "collinea/pipeline/project.h"

#include <fmt/format.h>

#include <array>
#include <functional>

#include "collinea/base/hash.h"
#include "collinea/pipeline/cost.h"
#include "collinea/pipeline/step.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;

struct Step {
  const char* name;
  Result<StepOutput> (*work)(Project&, const std::string& inputs_hash);
  std::vector<const char*> reads;     ///< earlier steps whose output it uses
  std::vector<const char*> products;  ///< files without which it is not done
  bool reads_control = false;         ///< control, map and position sigmas: all that import was given
};

// The only place that knows the order of work.
const std::array<Step, 8>& steps() {
  static const std::array<Step, 8> all = {{
      {"import", import_step, {}, {}},
      {"detect", detect_step, {"import"}, {}},
      {"match", match_step, {"import", "detect"}, {}},
      {"orient", orient_step, {"import", "match"}, {}, true},
      {"densify", densify_step, {"orient"}, {"products/cloud.las", "products/cloud.ply"}},
      {"surface", surface_step, {"orient", "densify"}, {}},
      {"ortho", ortho_step, {"orient", "surface"}, {}},
      {"report", report_step, {"import", "detect", "match", "orient", "densify", "surface", "ortho"}, {"report/report.html"}, true},
  }};
  return all;
}

Result<std::string> inputs_hash_of(const Project& project, const Step& step) {
  Hash hash;
  hash.add(COLLINEA_VERSION).add(step.name).add(options_text(project.settings, step.name));
  if (step.reads.empty()) hash.add(fingerprint_of_sources(project.settings.photos, project.settings.import));
  for (const char* earlier : step.reads) {
    COLLINEA_TRY(const auto record, project.store.read_step(earlier));
    COLLINEA_CHECK(record.has_value());
    hash.add(record->output_hash);
    if (step.reads_control && earlier == std::string_view("import")) hash.add(record->inputs_hash);
  }
  return hash.hex();
}

bool products_exist(const Project& project, const Step& step) {
  for (const char* product : step.products)
    if (!fs::exists(project.folder / product)) return false;
  return true;
}

Result<> do_step(Project& project, const Step& step) {
  COLLINEA_TRY(const std::string inputs_hash, inputs_hash_of(project, step));
  COLLINEA_TRY(const auto before, project.store.read_step(step.name));
  if (before && before->inputs_hash == inputs_hash && products_exist(project, step)) {
    project.run.say(fmt::format("{:<8} up to date", step.name));
    return {};
  }
  if (before)
    if (auto erased = project.store.erase_step(step.name); !erased) return erased;
  const CostMeter cost;
  project.run.report(step.name, 0);
  COLLINEA_TRY(const StepOutput output, step.work(project, inputs_hash).map_error([&](Error error) {
    return std::move(error).within(step.name);
  }));
  if (project.run.stopped()) return fail(Errc::kCancelled, fmt::format("{}: stopped; the same command goes on from here", step.name));
  project.run.report(step.name, 1);
  const StepRecord record{step.name,           inputs_hash,        output.output_hash,        cost.seconds(),
                          cost.cpu_seconds(), cost.peak_memory_bytes(), output.report_json};
  if (auto written = project.store.write_step(record); !written) return written;
  project.run.say(fmt::format("{:<8} {} ({:.1f} s, {:.1f} CPU-s, {:.0f} MB)", step.name, output.summary, record.seconds,
                              record.cpu_seconds, record.peak_memory_bytes / 1e6));
  return {};
}

}  // namespace

Result<Project> create_project(const fs::path& folder, const Settings& settings, const Run& run) {
  if (auto valid = validate_settings(settings); !valid) return tl::unexpected(valid.error());
  std::error_code error;
  if (!fs::is_directory(settings.photos, error))
    return fail(Errc::kNotFound, settings.photos + " is not a folder of photographs");
  fs::create_directories(folder, error);
  if (error) return fail(Errc::kBadInput, "cannot make " + folder.string() + ": " + error.message());
  COLLINEA_TRY(ProjectStore store, ProjectStore::open(folder));
  if (auto written = write_settings(folder, settings); !written) return tl::unexpected(written.error());
  Project project{folder, settings, std::move(store), run};
  project.run.seed = settings.seed;
  return project;
}

Result<Project> open_project(const fs::path& folder, const Run& run) {
  COLLINEA_TRY(const Settings settings, read_settings(folder));
  COLLINEA_TRY(ProjectStore store, ProjectStore::open(folder));
  Project project{folder, settings, std::move(store), run};
  project.run.seed = settings.seed;
  return project;
}

std::vector<std::string> step_names() {
  std::vector<std::string> names;
  for (const Step& step : steps()) names.push_back(step.name);
  return names;
}

Result<> bring_up_to(Project& project, const std::string& last) {
  for (const Step& step : steps()) {
    if (auto done = do_step(project, step); !done) return done;
    if (last == step.name) return {};
  }
  return fail(Errc::kBadInput, "no step is called " + last);
}

}  // namespace collinea
