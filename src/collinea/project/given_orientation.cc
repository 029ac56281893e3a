// SPDX-License-Identifier: Apache-2.0
#include "collinea/project/given_orientation.h"

#include <fmt/format.h>

#include <algorithm>

#include "collinea/base/file.h"
#include "collinea/base/hash.h"
#include "collinea/import/image_names.h"
#include "collinea/io/bundler.h"
#include "collinea/io/colmap.h"
#include "collinea/io/opk.h"
#include "collinea/project/fitted_camera.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;

constexpr double kSameFocal = 1e-3;  // relative: what cameras of one lens may differ by without a word

tl::unexpected<Error> unknown(const std::string& source, const std::string& image) {
  return fail(Errc::kBadInput, source + ": no photograph of the project is called " + image);
}

// The camera as of the images, under the name and with the sigma that these give it.
Result<Camera> fitted(Camera camera, const Camera& ours, const std::string& image) {
  COLLINEA_TRY(camera, fitted_to(std::move(camera), ours.width_px, ours.height_px, image));
  camera.name = ours.name;
  camera.prior.sigma_f_px = ours.prior.sigma_f_px;
  return camera;
}

// A model may know several cameras where the images say one: the one with the middle focal length is taken.
void take_common(const std::map<CameraId, std::vector<Camera>>& cameras, ReadOrientation& read) {
  for (const auto& [id, found] : cameras) {
    std::vector<Camera> sorted = found;
    std::stable_sort(sorted.begin(), sorted.end(),
                     [](const Camera& a, const Camera& b) { return a.focal_px() < b.focal_px(); });
    read.given.cameras[id] = sorted[sorted.size() / 2];
    if (sorted.back().focal_px() / sorted.front().focal_px() < 1 + kSameFocal) continue;
    read.findings.push_back(finding_of(
        FindingCode::kCamerasMerged, {Subject::file(read.given.source), id},
        {{FigureName::kFocalLowest, sorted.front().focal_px()}, {FigureName::kFocalHighest, sorted.back().focal_px()}},
        {OptionName{"refine_orientation", "orient"}}));
  }
}

Result<ReadOrientation> from_model(const Block& model, const Block& setup, const fs::path& path) {
  ReadOrientation read;
  read.given.source = path.string();
  const ImageNames names(setup);
  std::map<CameraId, std::vector<Camera>> cameras;
  for (const auto& [id, pose] : oriented_images(model)) {
    const std::string& file = model.images.at(id).file;
    const auto image = names.find(file);
    if (!image) return unknown(path.string(), file);
    if (!read.given.cam_from_world.emplace(*image, pose).second)
      return fail(Errc::kBadInput, path.string() + ": " + file + " is there twice");
    COLLINEA_TRY(Camera camera, fitted(model.camera_of(id), setup.camera_of(*image), file).map_error([&](Error error) {
      return std::move(error).within(path.string());
    }));
    // What the images say of a camera: that it is known and fixed.
    camera.prior.calibrate = setup.camera_of(*image).prior.calibrate;
    cameras[setup.images.at(*image).camera].push_back(camera);
  }
  take_common(cameras, read);
  return read;
}

Result<ReadOrientation> from_bundler(const fs::path& folder, const Block& setup) {
  const ImageNames names(setup);
  const auto size_of = [&](const std::string& name) -> Result<ImageSize> {
    const auto image = names.find(name);
    if (!image) return unknown((folder / "list.txt").string(), name);
    return ImageSize{setup.camera_of(*image).width_px, setup.camera_of(*image).height_px};
  };
  COLLINEA_TRY(const Block model, read_bundler(folder, size_of));
  return from_model(model, setup, folder);
}

Result<ReadOrientation> from_table(const fs::path& path, const Block& setup) {
  COLLINEA_TRY(std::vector<ExteriorOrientation> rows, read_opk(path));
  const ImageNames names(setup);
  for (ExteriorOrientation& row : rows) {
    const auto image = names.find(row.file);
    if (!image) return unknown(path.string(), row.file);
    row.file = setup.images.at(*image).file;
  }
  ReadOrientation read;
  read.given.source = path.string();
  read.given.in_world = setup.georeference.has_value();
  COLLINEA_TRY(read.given.cam_from_world,
               poses_of(rows, setup).map_error([&](Error error) { return std::move(error).within(path.string()); }));
  return read;
}

}  // namespace

Result<ReadOrientation> read_orientation(const fs::path& path, const Block& setup) {
  std::error_code ignored;
  if (fs::is_directory(path, ignored)) {
    if (is_there(path / "cameras.bin") || is_there(path / "cameras.txt")) {
      COLLINEA_TRY(const Block model, read_colmap(path));
      return from_model(model, setup, path);
    }
    if (is_there(path / "bundle.out")) return from_bundler(path, setup);
    return fail(Errc::kNotFound, path.string() +
                                     ": neither a COLMAP model (cameras.txt or cameras.bin) nor Bundler's bundle.out "
                                     "is in this folder");
  }
  if (!is_there(path)) return fail(Errc::kNotFound, path.string() + " does not exist");
  if (path.filename() == "bundle.out") return from_bundler(path.parent_path(), setup);
  return from_table(path, setup);
}

std::string fingerprint_of_orientation(const fs::path& path) {
  Hash hash;
  std::vector<fs::path> files{path};
  std::error_code ignored;
  if (path.filename() == "bundle.out") files = {path, path.parent_path() / "list.txt"};
  if (fs::is_directory(path, ignored)) {
    files.clear();
    for (const auto& entry : fs::directory_iterator(path, ignored)) files.push_back(entry.path());
    std::sort(files.begin(), files.end());
  }
  for (const fs::path& file : files) hash.add(file.string()).add(std::uint64_t{hash_of_file(file).value_or(0)});
  return hash.hex();
}

}  // namespace collinea
