// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "collinea/block/geodetic_words.h"
#include "collinea/report/finding_words.h"
#include "collinea/report/internal/adjustment_findings.h"
#include "collinea/report/internal/adjustment_products.h"
#include "collinea/report/internal/cells.h"
#include "collinea/report/internal/counted.h"
#include "collinea/report/internal/html_page.h"
#include "collinea/report/internal/svg.h"
#include "collinea/report/value_words.h"
#include "collinea/report/write_adjustment.h"

namespace collinea {
namespace {

constexpr std::size_t kMostRows = 50;
constexpr int kDecimals = 4;  // of lengths in metres, and more where standard deviations are small

// Of all rows of a table of points.
int decimals_of(const auto& points) {
  std::vector<double> sigmas;
  for (const auto& one : points)
    sigmas.insert(sigmas.end(), one.difference_sigma_m.begin(), one.difference_sigma_m.end());
  return decimals_for(sigmas, kDecimals);
}

std::string head(std::initializer_list<const char*> titles) {
  std::string html = "<table><thead><tr>";
  for (const std::string_view title : titles) {
    const bool is_text = title.data() == *titles.begin() || title == "role" || title == "unit";
    html += fmt::format("<th{}>{}</th>", is_text ? " class=\"l\"" : "", title);
  }
  return html + "</tr></thead><tbody>\n";
}

std::string summary(const AdjustmentReport& report) {
  const Examined& adjusted = report.adjusted;
  std::string html = "<section><h2>Adjustment</h2>\n<table class=\"pairs\"><tbody>\n";
  const auto row = [&](const char* name, const std::string& value) {
    html += "<tr>" + text_cell(name) + text_cell(value, "l w") + "</tr>\n";
  };
  row("sigma 0 (1: as assumed)", fmt::format("{:.3f}", adjusted.sigma0));
  row("observations", std::to_string(adjusted.observation_count));
  row("unknowns", std::to_string(adjusted.unknown_count));
  row("redundancy", std::to_string(adjusted.redundancy));
  row("datum", words_of(adjusted.datum, adjusted.rank_defect));
  if (const std::string points = datum_points_words(report); !points.empty()) row("datum points", points);
  row("converged",
      fmt::format("{}, {} iterations; weighted squares from {:.6g} to {:.6g}", adjusted.converged ? "yes" : "no",
                  adjusted.iterations, adjusted.initial_cost, adjusted.final_cost));
  row("last step of images and cameras", fmt::format("{:.1g} standard deviations", adjusted.last_step_sigmas));
  if (adjusted.conditioning.inflation > 0)
    row("conditioning",
        fmt::format("the worst combination of unknowns has {:.2g} times the variance that it would have "
                    "if all else were known; it is mostly {}",
                    adjusted.conditioning.inflation, words_of(adjusted.conditioning, report.block)));
  html += "</tbody></table>\n";
  if (adjusted.undetermined)
    html += "<p>There are no standard deviations. " +
            escaped(sentence_of(*adjusted.undetermined, report.block, report.spelling)) + "</p>\n";
  if (!adjusted.weaknesses.empty()) {
    html += "<h2>What is weak</h2>\n<ul>";
    for (const Finding& weak : adjusted.weaknesses)
      html += "<li>" + escaped(what_of(weak, report.block)) +
              "<br>Remedy: " + escaped(remedy_of(weak, report.spelling)) + "</li>\n";
    html += "</ul>\n";
  }
  return html + "</section>\n";
}

std::string control_table(const AdjustmentReport& report) {
  if (report.adjusted.control.empty()) return "";
  std::string html =
      "<section><h2>Control and check points</h2>\n<p>Estimated minus surveyed. &sigma;: what the difference is "
      "expected to be. Red: more than three times that.</p>\n" +
      head({"point", "role", "images", "east [m]", "north [m]", "height [m]", "&sigma; east [m]", "&sigma; north [m]",
            "&sigma; height [m]"});
  const int decimals = decimals_of(report.adjusted.control);
  for (const bool used : {false, true})
    for (const ControlDifference& one : report.adjusted.control) {
      if (one.used != used) continue;
      const ControlPoint& point = report.block.control.at(one.point);
      html +=
          "<tr>" + text_cell(point.name) + text_cell(used ? "control" : "check") + fmt::format("<td>{}</td>", one.rays);
      for (int i = 0; i < 3; ++i) html += difference_cell(one.difference_m[i], one.difference_sigma_m[i], decimals);
      for (int i = 0; i < 3; ++i) html += cell(one.difference_sigma_m[i], decimals);
      html += "</tr>\n";
    }
  return html + "</tbody></table></section>\n";
}

std::string geodetic_table(const AdjustmentReport& report) {
  if (report.adjusted.geodetic.empty()) return "";
  std::string html =
      "<section><h2>Measurements on the ground</h2>\n<p>Adjusted minus given. &sigma;: what the difference is expected "
      "to be. Red: more than three times that.</p>\n" +
      head({"measurement", "role", "unit", "given", "&sigma; given", "adjusted", "difference", "&sigma;"});
  for (const GeodeticDifference& one : report.adjusted.geodetic) {
    const GeodeticObservation& measured = report.block.geodetic[one.observation];
    const double unit = measured.is_angle() ? 180 / std::numbers::pi : 1;
    const double sigmas[] = {unit * measured.sigma, unit * one.difference_sigma};
    const int decimals = decimals_for(sigmas, measured.is_angle() ? 5 : kDecimals);
    html += "<tr>" + text_cell(words_of(measured, report.block)) + text_cell(one.used ? "used" : "check") +
            text_cell(measured.is_angle() ? "deg" : "m") + cell(unit * measured.value, decimals) +
            cell(unit * measured.sigma, decimals) + cell(unit * one.adjusted, decimals) +
            difference_cell(unit * one.difference, unit * one.difference_sigma, decimals) +
            cell(unit * one.difference_sigma, decimals) + "</tr>\n";
  }
  return html + "</tbody></table></section>\n";
}

std::string unknowns_table(const AdjustmentReport& report) {
  const std::vector<EstimatedUnknown> unknowns = shown_unknowns(report.adjusted);
  if (unknowns.empty()) return "";
  std::string html = "<section><h2>Lever arms, shifts, time offsets, boresight, orientations</h2>\n";
  for (const Finding& pair : report.adjusted.inseparable)
    html += "<p>" + escaped(sentence_of(pair, report.block, report.spelling)) + "</p>\n";
  html += head({"unknown", "unit", "value", "&sigma;"});
  for (const EstimatedUnknown& one : unknowns) {
    const double sigma = in_unit(one.kind, one.sigma) * sigma_scale(report.adjusted);
    const int decimals = decimals_for(sigma, kDecimals);
    html += "<tr>" + text_cell(words_of(subject_of(one.kind, one.owner, one.axis), report.block)) +
            text_cell(unit_of(one.kind)) + cell(in_unit(one.kind, one.value), decimals) + cell(sigma, decimals) +
            "</tr>\n";
  }
  return html + "</tbody></table></section>\n";
}

std::string left_out_table(const AdjustmentReport& report, const Reliability& tests) {
  if (tests.left_out.empty()) return "";
  std::string html =
      "<section><h2>Each control point against the others</h2>\n<p>What the difference would be, had the coordinates "
      "of "
      "the point not taken part (leave-one-out).</p>\n" +
      head({"point", "east [m]", "north [m]", "height [m]", "&sigma; east [m]", "&sigma; north [m]",
            "&sigma; height [m]"});
  const int decimals = decimals_of(tests.left_out);
  for (const LeftOutPoint& one : tests.left_out) {
    html += "<tr>" + text_cell(report.block.control.at(one.point).name);
    for (int i = 0; i < 3; ++i) html += difference_cell(one.difference_m[i], one.difference_sigma_m[i], decimals);
    for (int i = 0; i < 3; ++i) html += cell(one.difference_sigma_m[i], decimals);
    html += "</tr>\n";
  }
  return html + "</tbody></table></section>\n";
}

std::string folded_table(const AdjustmentReport& report, const Folded& folded) {
  if (folded.points.empty()) return "";
  std::string html = fmt::format(
      "<section><h2>Control in {} parts, each against the others</h2>\n<p>What the differences would be, had the "
      "coordinates of all points of the part not taken part: neighbours with the same error do not vouch for each "
      "other. ",
      folded.folds);
  const int decimals = decimals_of(folded.points);
  for (const bool height : {false, true})
    if (const LeftOutRms rms = rms_of(folded.points, height); rms.points > 0)
      html += fmt::format("{}: root mean square {:.{}f} m over {}, predicted {:.{}f} m. ", height ? "Height" : "Plan",
                          rms.difference_m, decimals, counted(rms.points, "point"), rms.predicted_m, decimals);
  html += "</p>\n" + head({"point", "part", "east [m]", "north [m]", "height [m]", "&sigma; east [m]",
                           "&sigma; north [m]", "&sigma; height [m]"});
  for (std::size_t k = 0; k < folded.points.size(); ++k) {
    const LeftOutPoint& one = folded.points[k];
    html += "<tr>" + text_cell(report.block.control.at(one.point).name) + fmt::format("<td>{}</td>", folded.part[k]);
    for (int i = 0; i < 3; ++i) html += difference_cell(one.difference_m[i], one.difference_sigma_m[i], decimals);
    for (int i = 0; i < 3; ++i) html += cell(one.difference_sigma_m[i], decimals);
    html += "</tr>\n";
  }
  return html + "</tbody></table></section>\n";
}

std::string group_table(const AdjustmentReport& report, const Reliability& tests) {
  std::string html =
      "<section><h2>Groups of observations</h2>\n<p>Factor: by what the standard deviations should be multiplied to "
      "agree with the residuals. Applied: by what they were.</p>\n" +
      head({"group", "observations", "redundancy", "factor", "applied"});
  for (std::size_t g = 0; g < kObservationGroups; ++g) {
    const GroupSums& sums = tests.groups[g];
    if (sums.observations == 0) continue;
    html += "<tr>" + text_cell(words_of(ObservationGroup(g))) + fmt::format("<td>{}</td>", sums.observations) +
            cell(sums.redundancy, 1) + cell(shown_factor(sums), 2) +
            cell(report.components ? report.components->factors[g] : 1, 2) + "</tr>\n";
  }
  return html + "</tbody></table></section>\n";
}

std::string test_rows(const std::vector<TestedObservation>& observations, const Block& block) {
  std::string html = head({"observation", "unit", "residual", "&sigma; given", "redundancy", "w", "gross error",
                           "minimal detectable", "its effect", "effect [&sigma;]"});
  for (std::size_t i = 0; i < std::min(observations.size(), kMostRows); ++i) {
    const TestedObservation one = in_unit(observations[i]);
    const std::string_view unit = unit_of(one);
    const int decimals = decimals_for(one.sigma, unit == "px" ? 2 : unit == "deg" ? 5 : kDecimals);
    html += "<tr>" + text_cell(name_of(one, block)) + text_cell(unit_of(one)) + cell(one.residual, decimals) +
            cell(one.sigma, decimals) + cell(one.redundancy, 2) +
            fmt::format("<td{}>{:+.1f}</td>", std::abs(one.w) > one.limit ? " class=\"bad\"" : "", one.w) +
            cell(one.gross_error, decimals) + cell(one.minimal_detectable_bias, decimals) + cell(one.effect, decimals) +
            cell(one.effect_in_sigmas, 1) + "</tr>\n";
  }
  return html + "</tbody></table>\n";
}

std::string words_of_unseen(long count) {
  if (count == 0) return "";
  if (count == 1)
    return " 1 measurement is of a point that lies where its image does not see it, behind it or out of its field: "
           "nothing can be stated of its size, and it comes first.";
  return fmt::format(
      " {} measurements are of points that lie where their image does not see them, behind it or out of its field: "
      "nothing can be stated of their size, and they come first.",
      count);
}

// The limits of tie points, where their errors show others than normal ones would have.
std::string words_of_tie_limits(const Reliability& tests) {
  if (tests.tie_limits.empty()) return "";
  const auto [least, most] = std::minmax_element(tests.tie_limits.begin(), tests.tie_limits.end());
  if (*least == tests.limit && *most == tests.limit) return "";
  return *most - *least < 0.005
             ? fmt::format(", tie points {:.2f} by the distribution of their errors", *most)
             : fmt::format(", tie points {:.2f} to {:.2f} by the distribution of their errors", *least, *most);
}

std::string words_of_mismatches(const AdjustmentReport& report) {
  if (!report.mismatches || report.mismatches->size() == 0) return "";
  return fmt::format(
      " Before, {} measurements of tie points were rejected as mismatches, and {} that might be wrong in their place.",
      report.mismatches->wrong.size(), report.mismatches->with_them.size());
}

std::string tests_section(const AdjustmentReport& report, const Reliability& tests) {
  std::string html = fmt::format(
      "<section><h2>Suspected gross errors</h2>\n<p>Of {} {} {} the limit {:.2f} of {}{}; about {:.0f} would do so by "
      "chance (level {:g}). Test again after rejecting the worst, which comes first: one gross error spoils its "
      "neighbours, and some of them may have a larger w.{}{}{}</p>\n",
      counted(tests.tested, "observation"), tests.rejected, tests.rejected == 1 ? "exceeds" : "exceed", tests.limit,
      tests.sigma0_known ? "Baarda's w" : "Pope's tau", words_of_tie_limits(tests),
      tests.false_alarm * double(tests.tested), tests.false_alarm, words_of_mismatches(report),
      words_of_unseen(tests.unseen),
      tests.suspects.size() > kMostRows ? " The worst are shown; suspects.csv has more." : "");
  if (!tests.suspects.empty()) html += test_rows(tests.suspects, report.block);
  html += "</section>\n";
  std::vector<TestedObservation> surveyed;
  for (const TestedObservation& one : tests.others)
    if (const ObservationSource source = traits_of(one.group).source;
        source == ObservationSource::kControlCoordinates || source == ObservationSource::kGeodetic)
      surveyed.push_back(one);
  if (!surveyed.empty())
    html += fmt::format(
                "<section><h2>Reliability of control{}</h2>\n<p>A gross error of the minimal detectable size is found "
                "with a "
                "probability of {:.0f} %; its effect is how far it would move the adjusted coordinate unnoticed.</p>\n",
                report.adjusted.geodetic.empty() ? "" : " and measurements on the ground", 100 * tests.power) +
            test_rows(surveyed, report.block) + "</section>\n";
  return html;
}

}  // namespace

std::string adjustment_page(const AdjustmentReport& report, const AdjustmentProducts& products) {
  std::string html = summary(report) + systematic_section(report) + snooping_section(report) + control_table(report) +
                     accuracy_section(report) + precision_section(report, products) + network_section(report) +
                     geodetic_table(report) + unknowns_table(report) + additional_section(report);
  if (report.adjusted.reliability) {
    const Reliability& tests = *report.adjusted.reliability;
    html += left_out_table(report, tests) + folded_table(report, tests.folded) + group_table(report, tests) +
            tests_section(report, tests);
  }
  html += weak_section(report) + correlation_section(report) + residual_section(report) + residual_test_section(report);
  html += "<footer>All figures are also in adjustment.json and the tables beside it.</footer>\n";
  return whole_page({report.title.empty() ? "Project" : report.title, "adjustment", "Adjustment report", ""}, html);
}

}  // namespace collinea
