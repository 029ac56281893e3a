// SPDX-License-Identifier: Apache-2.0
// Systematic errors: what was found, and every test.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "collinea/quality/systematic_findings.h"
#include "collinea/report/finding_words.h"
#include "collinea/report/internal/adjustment_findings.h"
#include "collinea/report/internal/cells.h"
#include "collinea/report/internal/finding_json.h"
#include "collinea/report/internal/svg.h"
#include "collinea/report/internal/systematic_words.h"
#include "collinea/report/json_values.h"

namespace collinea {
namespace {

using json = nlohmann::ordered_json;

constexpr std::size_t kMostListed = 3;  // values; those of additional parameters are in the JSON

// Angles are shown in degrees.
double shown_unit(std::string_view unit) { return unit == "rad" ? 180 / std::numbers::pi : 1; }
std::string_view shown_name(std::string_view unit) { return unit == "rad" ? "deg" : unit; }

std::string values_of(const SystematicTest& test) {
  if (test.values.size() > kMostListed) return fmt::format("{} parameters", test.values.size());
  std::string text;
  for (std::size_t k = 0; k < test.values.size(); ++k) {
    const double unit = shown_unit(test.unit), sigma = unit * test.sigmas[k];
    text += text.empty() ? "" : ", ";
    text += std::isfinite(sigma) ? fmt::format("{:.{}f} \xc2\xb1 {:.{}f}", unit * test.values[k],
                                               decimals_for(sigma, 3), sigma, decimals_for(sigma, 3))
                                 : "not determined";
  }
  return text + " " + std::string(shown_name(test.unit));
}

std::string verdict_of(const std::vector<SystematicTest>& tests, const SystematicTest& test, const Block& block) {
  if (!test.significant) return "no";
  if (!test.explained_by) return "yes";
  return "shadow of " + systematic_name(subject_of(tests[*test.explained_by]), block);
}

std::string chance_cell(double chance) {
  return chance < 1e-99 ? "<td>&lt; 1e-99</td>" : fmt::format("<td>{:.2g}</td>", chance);
}

std::string table_of(const AdjustmentReport& report) {
  const std::vector<SystematicTest>& tests = report.adjusted.systematics;
  std::string html =
      "<table><thead><tr><th class=\"l\">error</th><th class=\"l\">estimate if it alone were there</th><th>chance by "
      "accident</th><th>corrected for all tests</th><th>changes points by at most [m]</th><th>&sigma; of these</th><th "
      "class=\"l\">significant</th></tr></thead><tbody>\n";
  for (const SystematicTest& test : tests)
    html += "<tr>" + text_cell(systematic_name(subject_of(test), report.block), "l w") +
            text_cell(values_of(test), "l w") + chance_cell(test.p_value) + chance_cell(test.p_corrected) +
            cell(test.ground_change_m, 3) + cell(test.ground_change_sigmas, 1) +
            text_cell(verdict_of(tests, test, report.block), "l w") + "</tr>\n";
  return html + "</tbody></table>\n";
}

json numbers(const std::vector<double>& values, double unit) {
  json list = json::array();
  for (const double value : values) list.push_back(number(unit * value));
  return list;
}

json test_json(const SystematicTest& test, const Block& block) {
  const double unit = shown_unit(test.unit), effect = shown_unit(test.effect_unit);
  json j = {{"kind", word_of(test.kind)},
            {"error", systematic_name(subject_of(test), block)},
            {"unit", shown_name(test.unit)},
            {"values", numbers(test.values, unit)},
            {"sigmas", numbers(test.sigmas, unit)},
            {"statistic", number(test.statistic)},
            {"degrees", test.degrees},
            {"p_value", number(test.p_value)},
            {"p_corrected", number(test.p_corrected)},
            {"significant", test.significant},
            {"determined", test.determined},
            {"multiple_correlation", number(test.multiple_correlation)},
            {"effect", number(effect * test.largest_effect)},
            {"effect_unit", shown_name(test.effect_unit)},
            {"ground_change_m", number(test.ground_change_m)},
            {"ground_change_sigmas", number(test.ground_change_sigmas)}};
  if (test.explained_by) j["explained_by"] = *test.explained_by;
  if (!test.indistinguishable.empty()) j["indistinguishable"] = test.indistinguishable;
  return j;
}

}  // namespace

std::string systematic_section(const AdjustmentReport& report) {
  const std::vector<Finding> named = systematic_findings(report.adjusted.systematics, report.block);
  if (report.adjusted.systematics.empty() && report.taken_up.empty()) return "";
  std::string html = "<section><h2>Systematic errors</h2>\n";
  if (named.empty() && report.taken_up.empty()) html += "<p>Residuals show none.</p>\n";
  if (!named.empty() || !report.taken_up.empty()) html += "<ul>";
  for (const Finding& finding : report.taken_up) html += "<li>" + escaped(what_of(finding, report.block)) + "</li>\n";
  for (const Finding& finding : named)
    html += "<li>" + escaped(what_of(finding, report.block)) +
            "<br>Remedy: " + escaped(remedy_of(finding, report.spelling)) + "</li>\n";
  if (!named.empty() || !report.taken_up.empty()) html += "</ul>\n";
  if (!report.adjusted.systematics.empty())
    html +=
        "<h3>Every test</h3>\n<p>Score tests of errors that many observations have in common, after "
        "the adjustment, corrected for their number (Holm). A shadow is significant, but not beside the other "
        "one.</p>\n" +
        table_of(report);
  return html + "</section>\n";
}

json systematic_json(const AdjustmentReport& report) {
  json tests = json::array();
  for (const SystematicTest& test : report.adjusted.systematics) tests.push_back(test_json(test, report.block));
  return {{"taken_up", findings_json(report.taken_up, report.block)},
          {"named", findings_json(systematic_findings(report.adjusted.systematics, report.block), report.block)},
          {"tests", tests}};
}

}  // namespace collinea
