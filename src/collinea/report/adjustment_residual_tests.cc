// SPDX-License-Identifier: Apache-2.0
// Tests of residuals that assume no distribution.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "collinea/report/internal/adjustment_findings.h"
#include "collinea/report/internal/cells.h"
#include "collinea/report/internal/residual_words.h"
#include "collinea/report/json_values.h"

namespace collinea {
namespace {

using json = nlohmann::ordered_json;
using Kind = ResidualTestKind;

constexpr std::size_t kMostRows = 40;  // of many strips; all that is significant comes first

bool is_in_image(const ResidualTest& test) { return test.series != ResidualSeries::kPositions; }

std::string words_of(Kind kind) {
  switch (kind) {
    case Kind::kRuns:
      return "runs of signs";
    case Kind::kAutocorrelation:
      return "correlation of neighbours";
    case Kind::kNormal:
      return "normal distribution";
    case Kind::kTieErrors:
      return "distribution of tie points";
  }
  return "";
}

std::string series_of(const ResidualTest& test, const Block& block) {
  std::string owner;
  if (test.strip) owner = fmt::format("strip {}", *test.strip + 1);
  if (test.camera) owner = block.cameras.at(*test.camera).name;
  return residual_series_words(test.series, test.axis) + (owner.empty() ? "" : ", " + owner);
}

// Runs are one more than changes of sign.
std::string value_cells(const ResidualTest& test) {
  if (test.kind == Kind::kRuns) return fmt::format("<td>{:.0f}</td><td>{:.0f}</td>", test.value + 1, test.expected + 1);
  return cell(test.value, 3) + cell(test.expected, 3);
}

std::string row_of(const ResidualTest& test, const Block& block) {
  const bool is_ordered = test.kind == Kind::kRuns || test.kind == Kind::kAutocorrelation;
  return "<tr>" + text_cell(series_of(test, block)) + text_cell(words_of(test.kind)) +
         fmt::format("<td>{}</td>", test.count) + value_cells(test) +
         (is_ordered ? cell(test.correlation, 2) : "<td></td>") +
         fmt::format("<td>{:.{}f} {}</td><td>{:.2g}</td><td{}>{:.2g}</td></tr>\n", test.rms, is_in_image(test) ? 3 : 4,
                     is_in_image(test) ? "px" : "m", test.p_value, test.significant ? " class=\"bad\"" : "",
                     test.p_corrected);
}

}  // namespace

std::string residual_test_section(const AdjustmentReport& report) {
  std::vector<const ResidualTest*> tests;
  for (const ResidualTest& test : report.residual_tests) tests.push_back(&test);
  if (tests.empty()) return "";
  std::ranges::stable_sort(tests, std::greater{}, &ResidualTest::significant);
  const auto found = std::ranges::count_if(tests, &ResidualTest::significant);
  std::string html = fmt::format(
      "<section><h2>Order and distribution of residuals</h2>\n<p>Tests that assume no distribution, or test it. By "
      "accident one of them or more is significant with a chance of {:g}: corrected for their number (Holm), {} of {} "
      "{}. Runs, in the column of values: of one sign; expected: half as many changes of sign as neighbours. Distance "
      "of distributions: the largest (Kolmogorov, Smirnov); expected: that which half of samples as large exceed. "
      "Residuals of positions are made independent before; each tie point takes part with one ray.</p>\n",
      report.residual_level, found, tests.size(), found == 1 ? "is" : "are");
  html +=
      "<table><thead><tr><th class=\"l\">residuals</th><th class=\"l\">test</th><th>how "
      "many</th><th>value</th><th>expected</th><th>correlation</th><th>size</th><th>chance</th><th>corrected</th></tr>"
      "</thead><tbody>\n";
  for (std::size_t i = 0; i < tests.size(); ++i)
    if (i < kMostRows || tests[i]->significant) html += row_of(*tests[i], report.block);
  html += "</tbody></table>\n";
  if (tests.size() > kMostRows) html += "<p>adjustment.json has the others.</p>\n";
  return html + "</section>\n";
}

json residual_tests_json(const AdjustmentReport& report) {
  json tests = json::array();
  for (const ResidualTest& test : report.residual_tests) {
    json one = {{"test", word_of(test.kind)},
                {"series", word_of(test.series)},
                {"axis", residual_axis_word(test.series, test.axis)}};
    if (test.strip) one["strip"] = *test.strip + 1;
    if (test.camera) one["camera"] = report.block.cameras.at(*test.camera).name;
    one["count"] = test.count;
    one["value"] = number(test.value);
    one["expected"] = number(test.expected);
    if (test.kind == Kind::kRuns || test.kind == Kind::kAutocorrelation) one["correlation"] = number(test.correlation);
    one[is_in_image(test) ? "rms_px" : "rms_m"] = number(test.rms);
    one["p_value"] = number(test.p_value);
    one["p_corrected"] = number(test.p_corrected);
    one["significant"] = test.significant;
    tests.push_back(std::move(one));
  }
  return {{"level", report.residual_level}, {"tests", tests}};
}

}  // namespace collinea
