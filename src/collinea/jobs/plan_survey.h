// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "collinea/base/options.h"
#include "collinea/plan/control_layout.h"
#include "collinea/plan/planned_block.h"
#include "collinea/report/plan_report.h"

namespace collinea {

/// A survey that is planned, and what shall be reported of it.
struct PlanOptions {
  std::optional<std::filesystem::path> area;
  std::optional<std::string> crs;
  bool gains = true;
  int candidates = 8;
  int trials = 0;
  int seed = 1;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = PlanOptions;
    visit(Field{"area", &O::area, "", "file with the corners of the site: easting, northing in each line"}.leads_to(
        PathKind::kFile));
    visit(Field{"crs", &O::crs, "", "of the coordinates, such as EPSG:32633; nothing: a local plane"});
    visit(Field{"gains", &O::gains, "",
                "tell what one more control point, one more cross strip and measured projection centres would "
                "gain"});
    visit(Field{"candidates", &O::candidates, "1", "positions tried for that control point", 1, 1000});
    visit(
        Field{"trials", &O::trials, "1", "blocks with simulated errors, adjusted to try what is predicted", 0, 10000});
    visit(Field{"seed", &O::seed, "1", "of the simulated errors", 0});
  }
};

/// Predicts the precision of a survey and writes to the folder: plan.html, plan.json, stations.csv, control.csv,
/// sigma.tif (bands: standard deviations east, north, height, and number of images) and plan.gpkg. Errors: options,
/// files, those of the adjustment.
[[nodiscard]] Result<PlanReport> plan_survey(const FlightOptions& flight, const LayoutOptions& layout,
                                             const MeasurementOptions& measurements, const PlanOptions& options,
                                             const std::filesystem::path& folder, const Run& run);

}  // namespace collinea
