// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "collinea/feature/interest.h"
#include "collinea/feature/repeatability.h"
#include "collinea/io/text_table.h"

namespace collinea {

/// How many points of an image an operator finds again after a change of it.
struct RepeatabilityRow {
  InterestOperator method;
  ImageChange change;
  double amount;
  Repeatability result;
};

/// The points of an image, and what was tried with them.
struct InterestReport {
  std::string image;  ///< file
  int width = 0, height = 0;
  InterestOptions options;
  InterestPoints found;
  double tolerance_px = 0;
  std::vector<RepeatabilityRow> repeatability;
};

/// A row a point: number, position, strength, scale; with covariances their standard deviations, too.
[[nodiscard]] TextTable points_table(const InterestReport& report);
[[nodiscard]] TextTable repeatability_table(const InterestReport& report);
/// A picture by itself: a chart for each change, a curve for each operator.
[[nodiscard]] std::string repeatability_svg(const InterestReport& report);
/// For a terminal.
[[nodiscard]] std::string interest_text(const InterestReport& report);

}  // namespace collinea
