// SPDX-License-Identifier: Apache-2.0
#include "collinea/project/depth_folder.h"

#include <fmt/format.h>

#include <algorithm>

#include "collinea/base/file.h"
#include "collinea/raster/geotiff.h"

namespace collinea {

namespace fs = std::filesystem;

namespace {

bool is_map(const fs::path& path) {
  const std::string name = path.filename().string();
  return name.ends_with(".depth.tif") || name.ends_with(".sigma.tif");
}

// One that stays would pass for one of the new ones.
Result<> remove_maps(const fs::path& folder) {
  std::error_code error;
  for (auto it = fs::directory_iterator(folder, error); !error && it != fs::directory_iterator(); it.increment(error))
    if (is_map(it->path())) COLLINEA_TRY(remove_file(it->path()));
  if (error) return fail(Errc::kBadInput, folder.string() + ": cannot be read: " + error.message());
  return {};
}

}  // namespace

Result<DepthFolder> DepthFolder::open(const fs::path& folder, const std::string& inputs_hash, const Block& block,
                                      const WorkingImages& images) {
  const fs::path made_from = folder / "inputs.txt";
  if (read_file(made_from).value_or("") != inputs_hash) {
    std::error_code error;
    fs::create_directories(folder, error);
    if (error) return fail(Errc::kBadInput, "cannot make " + folder.string() + ": " + error.message());
    COLLINEA_TRY(remove_maps(folder));
    COLLINEA_TRY(write_file(made_from, inputs_hash));
  }
  return DepthFolder(folder, block, images);
}

fs::path DepthFolder::path(ImageId image, const char* what) const {
  std::string name = block_->images.at(image).file;
  std::replace(name.begin(), name.end(), '/', '_');  // a/b.jpg and a_b.jpg: only the number keeps them apart
  return folder_ / fmt::format("{:06}_{}.{}.tif", image.value, name, what);
}

// The depths come last: where they are, the sigmas are too.
Result<> DepthFolder::write(ImageId image, const DepthMap& map) {
  COLLINEA_TRY(write_float_tiff(path(image, "sigma"), map.sigma));
  return write_float_tiff(path(image, "depth"), map.depth);
}

Result<DepthMap> DepthFolder::read(ImageId image) {
  DepthMap map;
  COLLINEA_TRY(map.camera, images_->camera(image));
  COLLINEA_TRY(map.depth, read_float_tiff(path(image, "depth")));
  COLLINEA_TRY(map.sigma, read_float_tiff(path(image, "sigma")));
  while (map.camera.width_px > map.depth.width && map.camera.width_px > 1) map.camera = camera_of_level(map.camera, 1);
  if (map.depth.width != map.camera.width_px || map.depth.height != map.camera.height_px ||
      map.sigma.width != map.depth.width || map.sigma.height != map.depth.height)
    return fail(Errc::kBadFormat,
                path(image, "depth").string() + " has the wrong size: remove the folder depth and run again");
  return map;
}

bool DepthFolder::has(ImageId image) const { return is_there(path(image, "depth")); }

}  // namespace collinea
