// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "collinea/report/internal/coverage.h"
#include "collinea/report/statistics.h"

namespace collinea {

/// What is computed of the input, once, for page and JSON alike.
struct ReportSummary {
  std::string unit;  ///< of lengths: "m", or "units" of a model without scale
  ResidualStatistics residuals;
  Coverage coverage;
  Overlap overlap;
  AxisRms check, control, position;
  int check_points = 0, control_points = 0, excluded_points = 0;  ///< measured in at least one oriented image
  std::vector<ImageId> not_oriented;                              ///< without those that could not be read
  std::string statement;              ///< how good it is, in a sentence or two: what a surveyor signs
  std::vector<std::string> cautions;  ///< what to know before relying on it
};
[[nodiscard]] ReportSummary summary_of(const ReportInput& input);

/// "0.021 m", or a dash for what is not known. To millimetres, or to two digits when that says more (metres: to 0.1
/// mm).
[[nodiscard]] std::string length_text(std::optional<double> length, const std::string& unit);

}  // namespace collinea
