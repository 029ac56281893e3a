// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "collinea/base/file.h"
#include "collinea/project/json_text.h"
#include "collinea/project/places.h"
#include "collinea/project/seamlines_file.h"
#include "collinea/radiometry/view.h"
#include "collinea/raster/photo.h"
#include "collinea/steps/step.h"

namespace collinea {

namespace {

// Seamlines that were found are written for editing; those that were given are written, too, as they were understood,
// so that the products tell what was used, unless they are that very file.
Result<> keep_seamlines(const Project& project, const Block& block, const OrthoSummary& summary) {
  const auto path = project.folder / "products" / "seamlines.gpkg";
  const auto& given = project.settings.ortho.seamlines;
  std::error_code differs;
  if (given && std::filesystem::equivalent(*given, path, differs)) return {};
  return write_seamlines(path, summary.seamlines, block, summary.sources, summary.grid.wkt);
}

}  // namespace

Result<StepOutput> ortho_step(Project& project, const std::string& inputs_hash) {
  COLLINEA_TRY(const Block block, project.store.read_orientation());
  if (!looks_down(block))
    return StepOutput{inputs_hash, R"({"skipped_because": "the images do not look down: no orthophoto"})",
                      "the images do not look down on the scene: no orthophoto"};
  COLLINEA_TRY(const Places places, places_of(project, block));
  const auto products = project.folder / "products";
  COLLINEA_TRY(const HeightField surface, open_height_field(products / "dsm.tif", products / "dsm_sigma.tif"));
  // What is raised above the terrain is no place for seams; without a terrain model the surface's own steps must do.
  HeightField terrain;
  if (is_there(products / "dtm.tif")) {
    COLLINEA_TRY(terrain, open_height_field(products / "dtm.tif"));
  }
  const auto pixels = [&](ImageId image, int shrink) {
    return read_colour(project.photo(block.images.at(image)), shrink);
  };
  SeamGuides guides;
  if (terrain.read) guides.terrain = &terrain;
  std::vector<SeamPolygon> given;
  if (const auto& path = project.settings.ortho.seamlines) {
    std::vector<ImageId> oriented;
    for (const auto& [image, pose] : block.cam_from_world) oriented.push_back(image);
    COLLINEA_TRY(given, read_seamlines(*path, block, oriented, surface.grid.wkt));
    guides.given = &given;
  }
  const OrthoFiles files{products / "ortho.tif", products / "ortho_source.tif"};
  COLLINEA_TRY(const OrthoSummary summary, make_orthophoto(block, places.frame_or_null(), surface, guides, pixels,
                                                           places.pixel_m, files, project.settings.ortho, project.run));
  COLLINEA_TRY(keep_seamlines(project, block, summary));
  nlohmann::json sources = nlohmann::json::array();
  for (const ImageId image : summary.sources) sources.push_back(block.images.at(image).file);
  nlohmann::json not_followed = nlohmann::json::object();
  std::uint64_t cells_not_followed = 0;
  for (const auto& [source, cells] : summary.not_followed) {
    not_followed[block.images.at(summary.sources[source]).file] = cells;
    cells_not_followed += cells;
  }
  const nlohmann::json report = {{"cell_m", summary.grid.cell_m},
                                 {"width", summary.grid.width},
                                 {"height", summary.grid.height},
                                 {"painted_cells", summary.painted_cells},
                                 {"empty_cells", summary.empty_cells},
                                 {"photographs_used", summary.photographs_used},
                                 {"seam_length_m", summary.seam_length_m},
                                 {"seam_difference_grey", summary.seam_difference_grey},
                                 {"seam_step_grey", summary.seam_step_grey},
                                 {"cells_not_seen_by_their_seamlines_photograph", not_followed},
                                 {"sources", sources}};
  std::string follows;
  if (guides.given)
    follows =
        fmt::format(", as {} polygons of {} say but for {:.2f} % of the cells, which their photograph does not see",
                    given.size(), project.settings.ortho.seamlines->string(),
                    100 * double(cells_not_followed) / double(std::max<std::uint64_t>(1, summary.painted_cells)));
  return StepOutput{inputs_hash, json_text(report),
                    fmt::format("{} x {} cells of {:.3g} m from {} photographs, {:.0f} m of seams along which these "
                                "differ by {:.1f} grey levels{}",
                                summary.grid.width, summary.grid.height, summary.grid.cell_m, summary.photographs_used,
                                summary.seam_length_m, summary.seam_difference_grey, follows)};
}

}  // namespace collinea
