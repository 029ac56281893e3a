// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "collinea/ortho/view.h"
#include "collinea/pipeline/json_text.h"
#include "collinea/pipeline/step.h"
#include "collinea/surface/dtm.h"

namespace collinea {

Result<StepOutput> terrain_step(Project& project, const std::string& inputs_hash) {
  COLLINEA_TRY(const Block block, project.store.read_block());
  const auto without = [&](const std::string& why) {
    return StepOutput{inputs_hash, json_text({{"skipped_because", why + ": no terrain model"}}),
                      why + ": no terrain model"};
  };
  if (!looks_down(block)) return without("the images do not look down on the scene");
  if (!block.georeference) return without("the block has no scale, so that the size of objects is not known");
  const auto products = project.folder / "products";
  const DsmFiles dsm{products / "dsm.tif", products / "dsm_sigma.tif", products / "dsm_state.tif", {}};
  const DtmFiles files{products / "dtm.tif", products / "dtm_sigma.tif", products / "dtm_state.tif",
                       products / "contours.gpkg"};
  const auto made = build_dtm(dsm, files, project.settings.terrain, project.run);
  if (!made && made.error().code == Errc::kIllPosed) return without(made.error().message);
  COLLINEA_TRY(const DtmSummary summary, made);
  const double cells = double(summary.ground_cells + summary.interpolated_cells);
  const nlohmann::json report = {{"cell_m", summary.grid.cell_m},
                                 {"width", summary.grid.width},
                                 {"height", summary.grid.height},
                                 {"ground_cells", summary.ground_cells},
                                 {"interpolated_cells", summary.interpolated_cells},
                                 {"coarse_cell_m", summary.coarse_cell_m},
                                 {"lowest_m", summary.lowest_m},
                                 {"highest_m", summary.highest_m},
                                 {"mean_sigma_m", summary.mean_sigma_m},
                                 {"contour_m", summary.contour_m},
                                 {"contours", summary.contours}};
  return StepOutput{
      inputs_hash, json_text(report),
      fmt::format("ground seen in {:.1f} % of {} x {} cells{}", 100 * double(summary.ground_cells) / cells,
                  summary.grid.width, summary.grid.height,
                  summary.contour_m > 0 ? fmt::format(", contours every {:.4g} m", summary.contour_m) : std::string())};
}

}  // namespace collinea
