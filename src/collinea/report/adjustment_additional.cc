// SPDX-License-Identifier: Apache-2.0
// Additional parameters of cameras: their tests, and which to drop.
#include <fmt/format.h>

#include <cmath>

#include "collinea/report/internal/adjustment_findings.h"
#include "collinea/report/internal/cells.h"
#include "collinea/report/internal/svg.h"
#include "collinea/report/json_values.h"

namespace collinea {
namespace {

using json = nlohmann::ordered_json;

std::string_view set_of(const AdjustmentReport& report, const AdditionalTest& test) {
  return kAdditionalNames[std::size_t(report.block.cameras.at(test.camera).additional)];
}

std::string proposal(const AdditionalTest& test) {
  const std::string dropped = dropped_names(test);
  if (dropped.empty()) return "All are significant: keep them.";
  std::string text =
      test.kept == 0 ? "None is significant: do without them."
                     : fmt::format("Keep {} of {}; hold the others: {}.", test.kept, test.parameters.size(), dropped);
  if (test.dropped_chance < 1e-3)
    text += " Together those are significant all the same (F-test): a smaller or another set may say the same.";
  return text;
}

std::string inseparable(const AdditionalTest& test) {
  std::string text;
  for (const AdditionalParameter& one : test.parameters)
    if (one.multiple_correlation > kInseparable)
      text += fmt::format("{}{} (most like {}, {:+.3f})", text.empty() ? "" : ", ", param_name(one.param),
                          param_name(one.partner), one.correlation);
  return text;
}

}  // namespace

std::string dropped_names(const AdditionalTest& test) {
  std::string names;
  for (const AdditionalParameter& one : test.parameters)
    if (!one.keep) names += (names.empty() ? "" : ",") + param_name(one.param);
  return names;
}

std::string additional_section(const AdjustmentReport& report) {
  std::string html;
  for (const AdditionalTest& test : report.additional) {
    html += fmt::format("<h3>{}: {}</h3>\n<p>All {} are zero: F = {:.2f}, chance {:.2g}. {}</p>\n",
                        escaped(report.block.cameras.at(test.camera).name), set_of(report, test),
                        test.parameters.size(), test.f, test.chance, escaped(proposal(test)));
    if (const std::string alike = inseparable(test); !alike.empty())
      html += "<p>Not to be told from the other parameters of the camera: " + escaped(alike) + ".</p>\n";
    html +=
        "<table><thead><tr><th class=\"l\">parameter</th><th>value [px]</th><th>&sigma;</th><th>t</th><th>chance if "
        "zero</th><th>largest shift [px]</th><th class=\"l\">most like</th><th>correlation</th><th>with all</th><th "
        "class=\"l\">proposal</th></tr></thead><tbody>\n";
    for (const AdditionalParameter& one : test.parameters)
      html += "<tr>" + text_cell(param_name(one.param)) + cell(one.value_px, 4) + cell(one.sigma_px, 4) +
              cell(one.value_px / one.sigma_px, 1) + fmt::format("<td>{:.2g}</td>", one.chance) +
              cell(one.largest_px, 3) + text_cell(one.partner < 0 ? "" : param_name(one.partner)) +
              cell(one.correlation, 3) + cell(one.multiple_correlation, 3) + text_cell(one.keep ? "keep" : "drop") +
              "</tr>\n";
    html += "</tbody></table>\n";
  }
  if (html.empty()) return "";
  return fmt::format(
             "<section><h2>Additional parameters</h2>\n<p>t: value over its standard deviation; significant where that "
             "happens to a parameter that is zero with less than the chance {:g}. The proposal drops one by one, the "
             "weakest first, as the others would be without it.</p>\n",
             report.additional_level) +
         html + "</section>\n";
}

nlohmann::ordered_json additional_json(const AdjustmentReport& report) {
  json list = json::array();
  for (const AdditionalTest& test : report.additional) {
    json rows = json::array();
    for (const AdditionalParameter& one : test.parameters)
      rows.push_back({{"parameter", param_name(one.param)},
                      {"value_px", number(one.value_px)},
                      {"sigma_px", number(one.sigma_px)},
                      {"t", number(one.value_px / one.sigma_px)},
                      {"chance", number(one.chance)},
                      {"significant", one.significant},
                      {"largest_px", number(one.largest_px)},
                      {"most_like", one.partner < 0 ? "" : param_name(one.partner)},
                      {"correlation", number(one.correlation)},
                      {"multiple_correlation", number(one.multiple_correlation)},
                      {"keep", one.keep}});
    list.push_back({{"camera", report.block.cameras.at(test.camera).name},
                    {"set", set_of(report, test)},
                    {"level", report.additional_level},
                    {"f", number(test.f)},
                    {"chance", number(test.chance)},
                    {"kept", test.kept},
                    {"dropped_f", number(test.dropped_f)},
                    {"dropped_chance", number(test.dropped_chance)},
                    {"proposal", proposal(test)},
                    {"parameters", rows}});
  }
  return list;
}

}  // namespace collinea
