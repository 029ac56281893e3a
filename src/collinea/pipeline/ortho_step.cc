// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "collinea/image/photo.h"
#include "collinea/ortho/view.h"
#include "collinea/pipeline/json_text.h"
#include "collinea/pipeline/places.h"
#include "collinea/pipeline/step.h"

namespace collinea {

Result<StepOutput> ortho_step(Project& project, const std::string& inputs_hash) {
  COLLINEA_TRY(const Block block, project.store.read_block());
  if (!looks_down(block))
    return StepOutput{inputs_hash, R"({"skipped_because": "the images do not look down: no orthophoto"})",
                      "the images do not look down on the scene: no orthophoto"};
  COLLINEA_TRY(const Places places, places_of(project, block));
  const auto products = project.folder / "products";
  COLLINEA_TRY(const HeightField surface, open_height_field(products / "dsm.tif", products / "dsm_sigma.tif"));
  const auto pixels = [&](ImageId image, int shrink) {
    return read_colour(project.photo(block.images.at(image)), shrink);
  };
  const OrthoFiles files{products / "ortho.tif", products / "ortho_source.tif"};
  COLLINEA_TRY(const OrthoSummary summary, make_orthophoto(block, places.frame_or_null(), surface, pixels,
                                                           places.pixel_m, files, project.settings.ortho, project.run));
  nlohmann::json sources = nlohmann::json::array();
  for (const ImageId image : summary.sources) sources.push_back(block.images.at(image).file);
  const nlohmann::json report = {{"cell_m", summary.grid.cell_m},
                                 {"width", summary.grid.width},
                                 {"height", summary.grid.height},
                                 {"painted_cells", summary.painted_cells},
                                 {"empty_cells", summary.empty_cells},
                                 {"photographs_used", summary.photographs_used},
                                 {"sources", sources}};
  return StepOutput{inputs_hash, json_text(report),
                    fmt::format("{} x {} cells of {:.3g} m from {} photographs", summary.grid.width,
                                summary.grid.height, summary.grid.cell_m, summary.photographs_used)};
}

}  // namespace collinea
