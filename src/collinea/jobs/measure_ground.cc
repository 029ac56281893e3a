// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/measure_ground.h"

#include "collinea/jobs/marking_project.h"
#include "collinea/raster/image_window.h"
#include "collinea/restitution/plotted_vertex.h"
#include "collinea/restitution/stereo_view.h"

namespace collinea {
namespace {

Result<std::optional<std::pair<ImageId, ImageId>>> images_named(const Block& block, const std::string& names) {
  if (names.empty()) return std::optional<std::pair<ImageId, ImageId>>();
  const std::size_t comma = names.find(',');
  const std::array<std::string, 2> both{names.substr(0, comma),
                                        comma == std::string::npos ? "" : names.substr(comma + 1)};
  std::array<ImageId, 2> found{};
  for (std::size_t k = 0; k < 2; ++k) {
    for (const auto& [id, image] : block.images)
      if (image.file == both[k]) found[k] = id;
    if (!found[k].valid())
      return fail(Errc::kBadInput, "there is no image \"" + both[k] + "\" in the project", {"images"_option});
  }
  return std::optional(std::pair(found[0], found[1]));
}

std::array<std::string, 2> files_of(const Block& block, const StereoChoice& pair) {
  return {block.images.at(pair.images[0]).file, block.images.at(pair.images[1]).file};
}

}  // namespace

Result<GroundReport> measure_ground(const Project& project, const Eigen::Vector2d& on_map,
                                    const GroundOptions& options) {
  COLLINEA_TRY(validate(options));
  COLLINEA_TRY(const MarkingProject oriented, MarkingProject::read_with_precision(project));
  const Block& block = oriented.block;
  const MarkingBlock marking = oriented.marking();
  COLLINEA_TRY(const auto images, images_named(block, options.images));
  COLLINEA_TRY(const StereoView scene,
               stereo_view(marking, oriented.frame_or_null(), heights_by_need(project.folder / "products" / "dsm.tif"),
                           {on_map, images}));
  const PhotoWindow photo = [&](ImageId image, const PixelWindow& window) {
    const Camera& camera = block.camera_of(image);
    return read_grey_window(project.image_file(block.images.at(image)), camera.width_px, camera.height_px, window);
  };
  COLLINEA_TRY(const GroundMatch match, match_ground(block, scene.model, scene.mark, photo, options.match));
  GroundReport report{.files = files_of(block, scene.shown), .pair = scene.shown, .match = match};
  VertexPlotter plotter(marking, oriented.frame_or_null(), nullptr);
  const double sigma_px = match.mark_sigma_px();
  COLLINEA_TRY(const PlottedVertex vertex,
               plotter.plot(MarkedVertex{
                   {{scene.model.left, match.pixels[0], sigma_px}, {scene.model.right, match.pixels[1], sigma_px}}}));
  report.position = vertex.position;
  if (const auto covariance = plotter.covariance_in_map(vertex)) report.sigma_m = covariance->diagonal().cwiseSqrt();
  for (const StereoChoice& pair : scene.choices) report.others.push_back({files_of(block, pair), pair});
  return report;
}

}  // namespace collinea
