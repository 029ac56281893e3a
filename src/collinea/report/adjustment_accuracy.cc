// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "collinea/report/internal/adjustment_findings.h"
#include "collinea/report/internal/cells.h"
#include "collinea/report/json_values.h"

namespace collinea {
namespace {

using json = nlohmann::ordered_json;

constexpr int kEnoughPoints = 30;  // no fewer for a tested class (ASPRS 2023)
constexpr int kDecimals = 4;

// Root mean squares over check points [m]: in plan of both axes together, or in height.
struct Share {
  int points = 0;
  double fit = 0;                   // of the differences
  double survey = 0;                // of the standard deviations of the survey
  double predicted = std::nan("");  // of what the differences are expected to be
  [[nodiscard]] double accuracy() const { return std::hypot(fit, survey); }
};

Share part_of(const AdjustmentReport& report, const std::vector<ControlDifference>& control, int first_axis,
              int last_axis) {
  Share part;
  double fit = 0, survey = 0, predicted = 0;
  const bool any_used = std::any_of(control.begin(), control.end(), [](const auto& one) { return one.used; });
  for (const ControlDifference& one : control) {
    // Control that was found wrong is no check point; where none is used at all, every point is one.
    if (one.used || (any_used && report.block.control.at(one.point).role != ControlRole::kCheck)) continue;
    const Eigen::Vector3d& sigma_m = report.block.control.at(one.point).sigma_m;
    double square = 0, variance = 0, expected = 0;
    for (int axis = first_axis; axis <= last_axis; ++axis) {
      square += one.difference_m[axis] * one.difference_m[axis];
      variance += sigma_m[axis] * sigma_m[axis];
      expected += one.difference_sigma_m[axis] * one.difference_sigma_m[axis];
    }
    if (!std::isfinite(square) || !std::isfinite(variance)) continue;
    ++part.points;
    fit += square;
    survey += variance;
    predicted += expected;
  }
  if (part.points == 0) return part;
  part.fit = std::sqrt(fit / part.points);
  part.survey = std::sqrt(survey / part.points);
  part.predicted = std::sqrt(predicted / part.points);
  return part;
}

json json_of(const Share& part) {
  return {{"check_points", part.points},
          {"fit_rmse_m", number(part.fit)},
          {"survey_rmse_m", number(part.survey)},
          {"rmse_m", number(part.accuracy())}};
}

std::string row(const char* name, const Share& part, int decimals) {
  if (part.points == 0) return "";
  return "<tr>" + text_cell(name) + fmt::format("<td>{}</td>", part.points) + cell(part.fit, decimals) +
         cell(part.survey, decimals) + cell(part.accuracy(), decimals) + "</tr>\n";
}

// Check points when their rays take part, and when not.
struct BothWays {
  bool take_part = false;  // as adjusted
  const std::vector<ControlDifference>*with = nullptr, *without = nullptr;
};

std::optional<BothWays> both_ways(const AdjustmentReport& report) {
  if (!report.other_check_rays) return std::nullopt;
  const auto *own = &report.adjusted.control, *other = &report.other_check_rays->control;
  const bool take_part = report.scope.use_check_rays;
  return BothWays{take_part, take_part ? own : other, take_part ? other : own};
}

std::string check_ray_rows(const AdjustmentReport& report) {
  const auto ways = both_ways(report);
  if (!ways) return "";
  std::string html = fmt::format(
      "<h3>Rays of check points</h3>\n<p>Here they {}. The other row is of a second adjustment. Predicted: what the "
      "differences are expected to be, the survey included.</p>\n<table><thead><tr><th class=\"l\">rays of check "
      "points</th><th>check points</th><th>horizontal [m]</th><th>predicted [m]</th><th>vertical [m]</th><th>predicted "
      "[m]</th></tr></thead><tbody>\n",
      ways->take_part ? "take part, as those of tie points" : "take no part");
  for (const bool with : {false, true}) {
    const auto& control = with ? *ways->with : *ways->without;
    const Share plan = part_of(report, control, 0, 1), height = part_of(report, control, 2, 2);
    const double shown[] = {plan.fit, plan.predicted, height.fit, height.predicted};
    const int decimals = decimals_for(shown, kDecimals);
    html += "<tr>" + text_cell(with ? "take part" : "take no part") +
            fmt::format("<td>{}</td>", std::max(plan.points, height.points)) + cell(plan.fit, decimals) +
            cell(plan.predicted, decimals) + cell(height.fit, decimals) + cell(height.predicted, decimals) + "</tr>\n";
  }
  return html + "</tbody></table>\n";
}

json json_of_way(const AdjustmentReport& report, const std::vector<ControlDifference>& control) {
  json points = json::array();
  for (const ControlDifference& one : control)
    if (!one.used)
      points.push_back({{"name", report.block.control.at(one.point).name},
                        {"difference_m", vector(one.difference_m)},
                        {"sigma_m", vector(one.difference_sigma_m)}});
  json j;
  for (const bool height : {false, true}) {
    const Share part = height ? part_of(report, control, 2, 2) : part_of(report, control, 0, 1);
    if (part.points > 0)
      j[height ? "vertical" : "horizontal"] = {
          {"check_points", part.points}, {"fit_rmse_m", number(part.fit)}, {"predicted_m", number(part.predicted)}};
  }
  j["points"] = points;
  return j;
}

}  // namespace

std::string accuracy_section(const AdjustmentReport& report) {
  const Share plan = part_of(report, report.adjusted.control, 0, 1),
              height = part_of(report, report.adjusted.control, 2, 2);
  if (plan.points + height.points == 0) return "";
  const double shown[] = {plan.fit, plan.survey, height.fit, height.survey};
  const int decimals = decimals_for(shown, kDecimals);
  std::string html =
      "<section><h2>Accuracy at check points</h2>\n<p>Root mean squares by the ASPRS Positional Accuracy Standards for "
      "Digital Geospatial Data, edition 2 (2023): what check points differ by, the standard deviations of their "
      "survey, "
      "and both together. Of the block; surfaces and orthophotos add their own.</p>\n"
      "<table><thead><tr><th class=\"l\"></th><th>check points</th><th>fit [m]</th><th>survey [m]</th>"
      "<th>RMSE [m]</th></tr></thead><tbody>\n" +
      row("horizontal, RMSE_H", plan, decimals) + row("vertical, RMSE_V", height, decimals) + "</tbody></table>\n";
  if (plan.points > 0 && height.points > 0)
    html += fmt::format("<p>RMSE_3D {:.{}f} m.</p>\n", std::hypot(plan.accuracy(), height.accuracy()), decimals);
  if (std::min(plan.points, height.points) < kEnoughPoints)
    html += fmt::format(
        "<p>The standard asks for {} check points; with fewer these figures are an indication, no test of a "
        "class.</p>\n",
        kEnoughPoints);
  return html + check_ray_rows(report) + "</section>\n";
}

json accuracy_json(const AdjustmentReport& report) {
  const Share plan = part_of(report, report.adjusted.control, 0, 1),
              height = part_of(report, report.adjusted.control, 2, 2);
  json j = {{"standard", "ASPRS 2023"}, {"enough_check_points", std::min(plan.points, height.points) >= kEnoughPoints}};
  if (plan.points > 0) j["horizontal"] = json_of(plan);
  if (height.points > 0) j["vertical"] = json_of(height);
  if (plan.points > 0 && height.points > 0) j["rmse_3d_m"] = number(std::hypot(plan.accuracy(), height.accuracy()));
  if (const auto ways = both_ways(report))
    j["check_rays"] = {{"take_part", ways->take_part},
                       {"with", json_of_way(report, *ways->with)},
                       {"without", json_of_way(report, *ways->without)}};
  return j;
}

}  // namespace collinea
