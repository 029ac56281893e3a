// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/ortho/orthophoto.h"
#include "collinea/store/step_records.h"
#include "collinea/surface/dsm.h"

namespace collinea {

/// What is recorded of a surface model.
[[nodiscard]] inline SurfaceRecord surface_record(const DsmSummary& summary) {
  return {.cell_m = summary.grid.cell_m,
          .width = summary.grid.width,
          .height = summary.grid.height,
          .points = summary.points,
          .points_dropped = summary.points_dropped,
          .measured_cells = summary.measured_cells,
          .interpolated_cells = summary.interpolated_cells,
          .lowest_m = summary.lowest_m,
          .highest_m = summary.highest_m,
          .mean_sigma_m = summary.mean_sigma_m,
          .mean_sigma_relative_m = summary.mean_sigma_relative_m};
}

/// The same of an orthophoto whose seams were found.
[[nodiscard]] inline OrthoRecord ortho_record(const OrthoSummary& summary) {
  OrthoRecord record{.cell_m = summary.grid.cell_m,
                     .width = summary.grid.width,
                     .height = summary.grid.height,
                     .painted_cells = summary.painted_cells,
                     .empty_cells = summary.empty_cells,
                     .images_used = summary.images_used,
                     .seam_length_m = summary.seam_length_m,
                     .seam_difference_grey = summary.seam_difference_grey,
                     .seam_step_grey = summary.seam_step_grey,
                     .sources = summary.sources};
  for (const auto& [source, cells] : summary.not_followed) record.cells_not_followed[summary.sources[source]] = cells;
  return record;
}

}  // namespace collinea
