// SPDX-License-Identifier: Apache-2.0
#include "collinea/project/project.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <functional>

#include "collinea/base/file.h"
#include "collinea/base/hash.h"
#include "collinea/base/memory.h"
#include "collinea/cloud/las.h"
#include "collinea/project/cost.h"
#include "collinea/project/given_orientation.h"
#include "collinea/project/seamlines_file.h"
#include "collinea/raster/geotiff.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;

// What a program that was killed left half written. Nobody else is at work here, but other files may lie beside ours.
void sweep(const fs::path& folder) {
  if (!is_there(folder / "block.db")) return;
  std::error_code ignored;
  const auto remove_in = [&](const char* subfolder, const char* name_start, const char* extension_start) {
    for (auto it = fs::directory_iterator(folder / subfolder, ignored); it != fs::directory_iterator();
         it.increment(ignored)) {
      const fs::path name = it->path().filename();
      const bool half = name.extension().string().starts_with(extension_start) ||
                        name.stem().extension() == extension_start;  // contours.part.gpkg, and its -journal
      if (half && name.string().starts_with(name_start)) fs::remove(it->path(), ignored);
    }
  };
  for (const char* subfolder : {"products", "depth", "depth/overview", "report", "adjustment"})
    remove_in(subfolder, "", ".part");
  remove_in(".", "project.json", ".part");
  remove_in("scratch", "points_", ".bin");
  fs::remove(folder / "scratch", ignored);  // stays when it holds anything else
}

// Seamlines that are asked for anew are looked at before they are noted: a wrong file would stay in the project. Until
// there is a surface, nothing says which map and which images they are of.
Result<> check_new_seamlines(const fs::path& folder, const Settings& settings, const ProjectStore& store) {
  const auto& given = settings.ortho.seamlines;
  const fs::path surface = folder / "products" / "dsm.tif";
  if (!given || !is_there(surface)) return {};
  if (const auto noted = read_settings(folder); noted && noted->ortho.seamlines == given) return {};
  COLLINEA_TRY(const Block block, store.read_block());
  std::vector<ImageId> oriented;
  for (const auto& [image, pose] : oriented_images(block)) oriented.push_back(image);
  COLLINEA_TRY(const GeoTiffReader reader, GeoTiffReader::open(surface));
  const auto read = read_seamlines(*given, block, oriented, reader.grid().wkt);
  return read ? Result<>{} : tl::unexpected(read.error());
}

Result<ProjectStore> open_store(const fs::path& folder) {
  return ProjectStore::open(folder).map_error([&](Error error) { return with_advice(std::move(error), folder); });
}

}  // namespace

// A full disk and a damaged database show in many places, and in the words of many libraries.
std::string title_of(const Project& project) {
  std::error_code error;
  std::filesystem::path folder = std::filesystem::absolute(project.folder, error).lexically_normal();
  if (folder.filename().empty()) folder = folder.parent_path();
  return folder.filename().string();
}

Error with_advice(Error error, const fs::path& folder) {
  constexpr double kLittle_MB = 16;
  std::error_code unknown;
  const double left_MB = double(fs::space(folder, unknown).available) / 1e6;
  if (error.code == Errc::kBadInput && !unknown && left_MB < kLittle_MB)
    error = std::move(error).advising(
        fmt::format(" (only {:.0f} MB are left on the disk: free some space and give the command again)", left_MB));
  if (error.code == Errc::kBadFormat && error.message.find("block.db") != std::string::npos)
    error = std::move(error).advising("; remove that file and give the command again: everything is computed anew");
  return error;
}

fs::path Project::cloud() const { return folder / "products" / las_file_name("cloud", settings.densify.cloud); }

Result<Project> create_project(const fs::path& folder, const Settings& settings, const Run& run) {
  COLLINEA_TRY(validate_settings(settings));
  std::error_code error;
  if (!fs::is_directory(settings.photos, error))
    return fail(Errc::kNotFound, settings.photos + " is not a folder of photographs");
  if (const auto& given = settings.orient.orientation; given && !is_there(*given))
    return fail(Errc::kNotFound, "orient: " + given->string() + " does not exist", {"orientation"_option});
  if (const auto& given = settings.ortho.seamlines; given && !is_there(*given))
    return fail(Errc::kNotFound, "ortho: " + given->string() + " does not exist", {"seamlines"_option});
  if (const fs::path* given = settings.frames.frames.get<fs::path>(); given && !is_there(*given))
    return fail(Errc::kNotFound, "frames: " + given->string() + " does not exist", {"frames"_option});
  fs::create_directories(folder, error);
  if (error) return fail(Errc::kBadInput, "cannot make " + folder.string() + ": " + error.message());
  COLLINEA_TRY(auto lock, ProjectLock::take(folder));
  sweep(folder);
  COLLINEA_TRY(ProjectStore store, open_store(folder));
  COLLINEA_TRY(check_new_seamlines(folder, settings, store));
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

}  // namespace collinea
