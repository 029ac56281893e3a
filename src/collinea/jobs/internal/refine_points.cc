// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/internal/refine_points.h"

#include <fmt/format.h>

#include <algorithm>

#include "collinea/base/parallel.h"
#include "collinea/raster/image_file.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;

// The images of a folder by their names, with and without ending.
Result<std::map<std::string, fs::path>> files_in(const fs::path& folder) {
  std::error_code error;
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder, error))
    if (entry.is_regular_file() && is_image_name(entry.path())) files.push_back(entry.path());
  if (error) return fail(Errc::kNotFound, "cannot read the folder " + folder.string(), {"images"_option});
  std::sort(files.begin(), files.end());
  std::map<std::string, fs::path> out;
  for (const fs::path& file : files) {
    out.emplace(file.filename().string(), file);
    out.emplace(file.stem().string(), file);
  }
  return out;
}

struct LoadedView {
  std::string name;
  GreyImage image;
  Camera camera;
  Rigid3 cam_from_world;
};

Result<std::vector<LoadedView>> load(const std::map<std::string, Rigid3>& cam_from_world, const Camera& camera,
                                     const fs::path& folder, const Run& run) {
  COLLINEA_TRY(const auto files, files_in(folder));
  std::vector<LoadedView> views;
  for (const auto& [name, pose] : cam_from_world) {
    const auto file = files.find(name);
    if (file == files.end()) continue;
    LoadedView view{name, {}, camera, pose};
    COLLINEA_TRY(view.image, read_grey(file->second));
    view.camera.width_px = view.image.width;
    view.camera.height_px = view.image.height;
    views.push_back(std::move(view));
    run.report("images", double(views.size()) / double(cam_from_world.size()));
    if (run.stopped()) return fail(Errc::kCancelled, "stopped");
  }
  if (views.size() < 2)
    return fail(
        Errc::kNotFound,
        fmt::format("{} has {} of the oriented images; two are needed. Files bear the names of the tables, with "
                    "or without their ending",
                    folder.string(), views.size()),
        {"images"_option});
  return views;
}

}  // namespace

Result<std::vector<IntersectionReport::Refined>> refine_points(const std::vector<PointToRefine>& points,
                                                               const std::map<std::string, Rigid3>& cam_from_world,
                                                               const Camera& camera, const fs::path& folder,
                                                               const MultiImageOptions& options, const Run& run) {
  COLLINEA_TRY(const std::vector<LoadedView> loaded, load(cam_from_world, camera, folder, run));
  std::vector<OrientedView> views;
  std::vector<std::string> names;
  for (const LoadedView& view : loaded) {
    views.push_back({&view.image, &view.camera, view.cam_from_world});
    names.push_back(view.name);
  }
  std::vector<IntersectionReport::Refined> out(points.size());
  for (const PointToRefine& point : points)
    if (std::find(names.begin(), names.end(), point.reference) == names.end())
      return fail(Errc::kNotFound,
                  fmt::format("point {} is measured first in image {}, which is not in {}", point.name, point.reference,
                              folder.string()),
                  {"images"_option});
  parallel_for(run, points.size(), [&](std::size_t i) {
    const PointToRefine& point = points[i];
    const auto reference = std::size_t(std::find(names.begin(), names.end(), point.reference) - names.begin());
    out[i].name = point.name;
    out[i].reference = point.reference;
    out[i].images = names;
    out[i].match = match_in_images(views, reference, point.pixel, point.start_in_world, options);
    out[i].moved = out[i].match.point_in_world - point.start_in_world;
  });
  if (run.stopped()) return fail(Errc::kCancelled, "stopped");
  return out;
}

}  // namespace collinea
