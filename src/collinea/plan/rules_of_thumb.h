// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "collinea/plan/precision.h"

namespace collinea {

/// What a rule for the design of a survey is of; image scale 1 : mb, height above ground h.
enum class PlanRule : std::uint8_t {
  kSignalisedPlan,             ///< 6 um mb
  kSignalisedHeight,           ///< 0.06 per mille of h
  kSignalisedHeightSuperWide,  ///< 0.08 per mille of h
  kNormalCaseHeight,           ///< of a point in two neighbouring images: h / base GSD sqrt(2) sigma_px
  kManholePlan,                ///< how well it is defined, 5 cm, on top of signalised points
  kManholeHeight,              ///< 2 cm
  kCornerPlan,                 ///< of a house or fence: 9.5 cm
  kCornerHeight,               ///< 11.5 cm
  kLinesPlan,                  ///< 45 um mb
  kContours,                   ///< on gentle slopes: 0.25 per mille of h
};
inline constexpr std::size_t kPlanRules = static_cast<std::size_t>(PlanRule::kContours) + 1;

/// A rule for the design of a survey, beside what the adjustment predicts.
struct RuleOfThumb {
  PlanRule rule{};
  double value_m = 0;                 ///< by the rule
  std::optional<double> predicted_m;  ///< the same by the adjustment, where it says so
};

/// What is customary of a flight.
enum class PlanCustom : std::uint8_t {
  kForwardOverlap,    ///< 60 % and more
  kSideOverlap,       ///< 20 % and more
  kTiePoints,         ///< six and more of three and more images in every image
  kControlAtCorners,  ///< four control points and more, at the corners of the block
};

/// Whether a custom is kept.
struct Custom {
  PlanCustom what{};
  bool kept = true;
};

/// The a-priori precisions that analytical photogrammetry goes by (V. Franco; image scale 1 : mb, height h), and the
/// normal case of two images.
[[nodiscard]] std::vector<RuleOfThumb> rules_of_thumb(const FlightPlan& plan, const FlightOptions& flight,
                                                      const MeasurementOptions& options, const Precision& precision);
/// Overlaps, tie points and control by the same book.
[[nodiscard]] std::vector<Custom> customs(const FlightPlan& plan, const FlightOptions& flight,
                                          const std::vector<PlannedPoint>& points, const Precision& precision);

}  // namespace collinea
