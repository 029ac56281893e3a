// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/plan_words.h"

#include <fmt/format.h>

#include "collinea/base/words.h"

namespace collinea {
namespace {

struct RuleWords {
  PlanRule rule;
  std::string_view of, formula;
};

constexpr RuleWords kRules[] = {
    {PlanRule::kSignalisedPlan, "signalised points, plan", "6 um * mb"},
    {PlanRule::kSignalisedHeight, "signalised points, height", "0.06 ‰ * h"},
    {PlanRule::kSignalisedHeightSuperWide, "signalised points, height", "0.08 ‰ * h (super-wide)"},
    {PlanRule::kNormalCaseHeight, "point in two neighbouring images only (normal case), height",
     "h / base * GSD * sqrt(2) * sigma_px"},
    {PlanRule::kManholePlan, "manhole, plan", "sqrt(signalised^2 + (5 cm)^2)"},
    {PlanRule::kManholeHeight, "manhole, height", "sqrt(signalised^2 + (2 cm)^2)"},
    {PlanRule::kCornerPlan, "corner of a house or fence, plan", "sqrt(signalised^2 + (9.5 cm)^2)"},
    {PlanRule::kCornerHeight, "corner of a house or fence, height", "sqrt(signalised^2 + (11.5 cm)^2)"},
    {PlanRule::kLinesPlan, "lines in plan", "45 um * mb"},
    {PlanRule::kContours, "contours on gentle slopes", "0.25 ‰ * h"},
};

static_assert(is_in_order(kRules, kPlanRules, &RuleWords::rule));

const RuleWords& row_of(PlanRule rule) { return kRules[static_cast<std::size_t>(rule)]; }

}  // namespace

std::string_view words_of(PlanRule rule) { return row_of(rule).of; }
std::string_view formula_of(PlanRule rule) { return row_of(rule).formula; }

std::string_view words_of(PlanCustom custom) {
  switch (custom) {
    case PlanCustom::kForwardOverlap:
      return "forward overlap of 60 % and more";
    case PlanCustom::kSideOverlap:
      return "side overlap of 20 % and more";
    case PlanCustom::kTiePoints:
      return "six and more tie points of three and more images in every image";
    case PlanCustom::kControlAtCorners:
      return "four control points and more, at the corners of the block (with measured projection centres they stay as "
             "a check)";
  }
  return "";
}

std::string words_of(const Gain& gain) {
  switch (gain.by) {
    case GainBy::kControlPoint:
      return "one more control point";
    case GainBy::kCrossStrip:
      return "one more cross strip";
    case GainBy::kPositions:
      return fmt::format("projection centres by RTK ({:.0f}, {:.0f}, {:.0f} mm)", 1000 * gain.sigma_m.x(),
                         1000 * gain.sigma_m.y(), 1000 * gain.sigma_m.z());
  }
  return "";
}

}  // namespace collinea
