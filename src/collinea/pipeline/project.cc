// SPDX-License-Identifier: Apache-2.0
#include "collinea/pipeline/project.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <functional>

#include "collinea/base/hash.h"
#include "collinea/base/memory.h"
#include "collinea/image/geotiff.h"
#include "collinea/io/file.h"
#include "collinea/io/las.h"
#include "collinea/pipeline/cost.h"
#include "collinea/pipeline/given_orientation.h"
#include "collinea/pipeline/seamlines_file.h"
#include "collinea/pipeline/step.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;

constexpr const char* kStopped = "stopped; the same command goes on from here";

struct Step {
  const char* name;
  Result<StepOutput> (*work)(Project&, const std::string& inputs_hash);
  std::vector<const char*> reads;     ///< earlier steps whose output it uses
  std::vector<const char*> products;  ///< files without which it is not done
  bool reads_setup = false;           ///< control, map and position sigmas too: all that import left in the store
  bool reads_sources = false;         ///< what import was given, with the remarks on it
};

constexpr const char* kCloud = "products/cloud in the form asked for";

// The only place that knows the order of work.
const std::array<Step, 9>& steps() {
  static const std::array<Step, 9> all = {{
      {"import", import_step, {}, {}},
      {"detect", detect_step, {"import"}, {}},
      {"match", match_step, {"import", "detect"}, {}},
      {"orient", orient_step, {"import", "match"}, {}, /*reads_setup=*/true},
      {"densify", densify_step, {"orient"}, {kCloud, "products/cloud.ply"}},
      {"surface",
       surface_step,
       {"orient", "densify"},
       {"products/dsm.tif", "products/dsm_sigma.tif", "products/dsm_state.tif", "products/dsm_count.tif",
        "products/dsm_sigma_relative.tif", "products/dsm_hillshade.tif"}},
      {"terrain",
       terrain_step,
       {"orient", "surface"},
       {"products/dtm.tif", "products/dtm_sigma.tif", "products/dtm_state.tif", "products/dtm_sigma_relative.tif",
        "products/dtm_hillshade.tif"}},
      {"ortho",
       ortho_step,
       {"orient", "surface", "terrain"},
       {"products/ortho.tif", "products/ortho_source.tif", "products/seamlines.gpkg"}},
      {"report",
       report_step,
       {"import", "detect", "match", "orient", "densify", "surface", "terrain", "ortho"},
       {"report/report.html"},
       /*reads_setup=*/true,
       /*reads_sources=*/true},
  }};
  return all;
}

Result<std::string> inputs_hash_of(const Project& project, const Step& step) {
  Hash hash;
  hash.add(COLLINEA_VERSION).add(step.name).add(options_text(project.settings, step.name));
  if (step.reads.empty()) hash.add(fingerprint_of_sources(project.settings.photos, project.settings.import));
  if (const auto& given = project.settings.orient.orientation; given && step.name == std::string_view("orient"))
    hash.add(fingerprint_of_orientation(*given));
  if (const auto& given = project.settings.ortho.seamlines; given && step.name == std::string_view("ortho"))
    hash.add(std::uint64_t{hash_of_file(*given).value_or(0)});
  for (const char* earlier : step.reads) {
    COLLINEA_TRY(const auto record, project.store.read_step(earlier));
    COLLINEA_CHECK(record.has_value());
    hash.add(record->output_hash);
    if (step.reads_sources && earlier == std::string_view("import")) hash.add(record->inputs_hash);
  }
  if (step.reads_setup) {
    COLLINEA_TRY(const std::uint64_t setup, project.store.setup_hash());
    hash.add(setup);
  }
  return hash.hex();
}

// A step that finds nothing to make says why, and leaves no product.
bool made_nothing(const std::string& report_json) {
  return report_json.find("\"skipped_because\"") != std::string::npos;
}

fs::path product_path(const Project& project, const char* product) {
  return product == std::string_view(kCloud) ? project.cloud() : project.folder / product;
}

bool products_exist(const Project& project, const Step& step, const StepRecord& record) {
  if (made_nothing(record.report_json)) return true;
  for (const char* product : step.products)
    if (!is_there(product_path(project, product))) return false;
  return true;
}

// What a program that was killed left half written. Nobody else is at work here, but other files may lie beside ours.
void sweep(const fs::path& folder) {
  if (!is_there(folder / "block.db")) return;
  std::error_code ignored;
  const auto remove_in = [&](const char* place, const char* name_start, const char* extension_start) {
    for (auto it = fs::directory_iterator(folder / place, ignored); it != fs::directory_iterator();
         it.increment(ignored)) {
      const fs::path name = it->path().filename();
      const bool half = name.extension().string().starts_with(extension_start) ||
                        name.stem().extension() == extension_start;  // contours.part.gpkg, and its -journal
      if (half && name.string().starts_with(name_start)) fs::remove(it->path(), ignored);
    }
  };
  for (const char* place : {"products", "depth", "depth/overview", "report", "adjustment"})
    remove_in(place, "", ".part");
  remove_in(".", "project.json", ".part");
  remove_in("scratch", "points_", ".bin");
  fs::remove(folder / "scratch", ignored);  // stays when it holds anything else
}

// A full disk and a damaged database show in many places, and in the words of many libraries.
Error with_advice(Error error, const fs::path& folder) {
  constexpr double kLittle_MB = 16;
  std::error_code unknown;
  const double left_MB = double(fs::space(folder, unknown).available) / 1e6;
  if (error.code == Errc::kBadInput && !unknown && left_MB < kLittle_MB)
    error.message +=
        fmt::format(" (only {:.0f} MB are left on the disk: make room and give the command again)", left_MB);
  if (error.code == Errc::kBadFormat && error.message.find("block.db") != std::string::npos)
    error.message += "; remove that file and give the command again: everything is computed anew";
  return error;
}

Result<> do_step(Project& project, const Step& step) {
  COLLINEA_TRY(const std::string inputs_hash, inputs_hash_of(project, step));
  COLLINEA_TRY(const auto before, project.store.read_step(step.name));
  if (before && before->inputs_hash == inputs_hash && products_exist(project, step, *before)) {
    project.run.say(fmt::format("{:<8} up to date", step.name));
    return {};
  }
  if (before)
    if (auto erased = project.store.erase_step(step.name); !erased) return erased;
  give_back_freed_memory();  // of the steps before
  const CostMeter cost;
  project.run.report(step.name, 0);
  COLLINEA_TRY(const StepOutput output, step.work(project, inputs_hash).map_error([&](Error error) {
    if (error.code == Errc::kCancelled) error.message = kStopped;
    return with_advice(std::move(error), project.folder).within(step.name);
  }));
  if (project.run.stopped()) return fail(Errc::kCancelled, fmt::format("{}: {}", step.name, kStopped));
  project.run.report(step.name, 1);
  if (made_nothing(output.report_json))
    for (const char* product : step.products)
      if (auto removed = remove_file(product_path(project, product)); !removed) return removed;
  const StepRecord record{step.name,         inputs_hash,        output.output_hash,
                          cost.seconds(),    cost.cpu_seconds(), cost.peak_memory_bytes(),
                          output.report_json};
  if (auto written = project.store.write_step(record); !written) return written;
  project.run.say(fmt::format("{:<8} {} ({:.1f} s, {:.1f} CPU-s, {:.0f} MB)", step.name, output.summary, record.seconds,
                              record.cpu_seconds, record.peak_memory_bytes / 1e6));
  return {};
}

// Seamlines that are asked for anew are looked at before they are noted: a wrong file would stay in the project. Until
// there is a surface, nothing says which map and which photographs they are of.
Result<> check_new_seamlines(const fs::path& folder, const Settings& settings, const ProjectStore& store) {
  const auto& given = settings.ortho.seamlines;
  const fs::path surface = folder / "products" / "dsm.tif";
  if (!given || !is_there(surface)) return {};
  if (const auto noted = read_settings(folder); noted && noted->ortho.seamlines == given) return {};
  COLLINEA_TRY(const Block block, store.read_block());
  std::vector<ImageId> oriented;
  for (const auto& [image, pose] : block.cam_from_world) oriented.push_back(image);
  COLLINEA_TRY(const GeoTiffReader reader, GeoTiffReader::open(surface));
  const auto read = read_seamlines(*given, block, oriented, reader.grid().wkt);
  return read ? Result<>{} : tl::unexpected(read.error());
}

Result<ProjectStore> open_store(const fs::path& folder) {
  return ProjectStore::open(folder).map_error([&](Error error) { return with_advice(std::move(error), folder); });
}

}  // namespace

fs::path Project::cloud() const {
  return folder / "products" / las_file_name("cloud", *las_form_of(settings.densify.cloud));
}

Result<Project> create_project(const fs::path& folder, const Settings& settings, const Run& run) {
  if (auto valid = validate_settings(settings); !valid) return tl::unexpected(valid.error());
  std::error_code error;
  if (!fs::is_directory(settings.photos, error))
    return fail(Errc::kNotFound, settings.photos + " is not a folder of photographs");
  if (const auto& given = settings.orient.orientation; given && !is_there(*given))
    return fail(Errc::kNotFound, "orient: orientation: " + *given + " does not exist");
  if (const auto& given = settings.ortho.seamlines; given && !is_there(*given))
    return fail(Errc::kNotFound, "ortho: seamlines: " + *given + " does not exist");
  fs::create_directories(folder, error);
  if (error) return fail(Errc::kBadInput, "cannot make " + folder.string() + ": " + error.message());
  COLLINEA_TRY(auto lock, ProjectLock::take(folder));
  sweep(folder);
  COLLINEA_TRY(ProjectStore store, open_store(folder));
  if (auto fine = check_new_seamlines(folder, settings, store); !fine) return tl::unexpected(std::move(fine).error());
  if (auto written = write_settings(folder, settings); !written)
    return tl::unexpected(with_advice(std::move(written).error(), folder));
  Project project{folder, settings, std::move(store), run, std::move(lock)};
  project.run.seed = settings.seed;
  return project;
}

Result<Project> open_project(const fs::path& folder, const Run& run) {
  COLLINEA_TRY(const Settings settings, read_settings(folder));
  COLLINEA_TRY(ProjectStore store, ProjectStore::open_to_read(folder).map_error(
                                       [&](Error error) { return with_advice(std::move(error), folder); }));
  Project project{folder, settings, std::move(store), run};
  project.run.seed = settings.seed;
  return project;
}

std::vector<std::string> step_names() {
  std::vector<std::string> names;
  for (const Step& step : steps()) names.push_back(step.name);
  return names;
}

Result<> check_step_name(const std::string& name) {
  std::string known;
  for (const Step& step : steps()) {
    if (name == step.name) return {};
    known += (known.empty() ? "" : ", ") + std::string(step.name);
  }
  return fail(Errc::kBadInput, "no step is called \"" + name + "\": choose one of " + known);
}

Result<> record_done(Project& project, const std::string& name, const StepOutput& output) {
  if (auto known = check_step_name(name); !known) return known;
  const Step& step = *std::find_if(steps().begin(), steps().end(), [&](const Step& s) { return name == s.name; });
  COLLINEA_TRY(const std::string inputs_hash, inputs_hash_of(project, step));
  return project.store.write_step({name, inputs_hash, output.output_hash, 0, 0, 0, output.report_json});
}

Result<> bring_up_to(Project& project, const std::string& last) {
  if (auto known = check_step_name(last); !known) return known;
  for (const Step& step : steps()) {
    if (auto done = do_step(project, step); !done) return done;
    if (last == step.name) break;
  }
  return {};
}

}  // namespace collinea
