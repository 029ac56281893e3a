// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "collinea/plan/precision.h"
#include "collinea/plan/rules_of_thumb.h"

namespace collinea {

/// All that is reported of a planned survey.
struct PlanReport {
  std::string title;
  std::string crs_name;  ///< empty: a local plane
  FlightOptions flight;
  MeasurementOptions measurements;
  FlightPlan plan;
  std::vector<PlannedPoint> points;
  Precision precision;
  std::vector<Gain> gains;
  std::optional<Trials> trials;
  std::vector<RuleOfThumb> rules;
  std::vector<Custom> customs;
};

[[nodiscard]] std::string plan_page(const PlanReport& report);  ///< HTML in one file
[[nodiscard]] std::string plan_json(const PlanReport& report);  ///< the same figures
[[nodiscard]] std::string plan_text(const PlanReport& report);  ///< the gist, for a terminal

// Drawings of the page, each a complete <svg>.
/// Flight lines, stations, control and, at a few positions, ellipses and height bars.
[[nodiscard]] std::string plan_map(const PlanReport& report);
/// How the standard deviation in plan or height lies over the area.
[[nodiscard]] std::string sigma_map(const PlanReport& report, bool height);

}  // namespace collinea
