// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "collinea/plan/precision.h"

namespace collinea {

/// A rule for the design of a survey, beside what the adjustment predicts.
struct RuleOfThumb {
  std::string name, formula;
  double value_m = 0;                 ///< by the rule
  std::optional<double> predicted_m;  ///< the same by the adjustment, where it says so
};

/// What is customary of a flight, and whether it is kept.
struct Custom {
  std::string what;
  bool kept = true;
};

/// The a-priori precisions that analytical photogrammetry goes by (V. Franco; photo scale 1 : mb, height h), and the
/// normal case of two pictures.
[[nodiscard]] std::vector<RuleOfThumb> rules_of_thumb(const FlightPlan& plan, const FlightOptions& flight,
                                                      const MeasurementOptions& options, const Precision& precision);
/// Overlaps, tie points and control by the same book.
[[nodiscard]] std::vector<Custom> customs(const FlightPlan& plan, const FlightOptions& flight,
                                          const std::vector<PlannedPoint>& points, const Precision& precision);

}  // namespace collinea
