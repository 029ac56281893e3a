// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "collinea/block/geodetic_words.h"
#include "collinea/report/finding_words.h"
#include "collinea/report/internal/adjustment_findings.h"
#include "collinea/report/internal/cells.h"
#include "collinea/report/internal/counted.h"
#include "collinea/report/internal/svg.h"
#include "collinea/report/json_values.h"

namespace collinea {
namespace {

using json = nlohmann::ordered_json;

constexpr std::size_t kMostRows = 50;

std::string name_of(const Measurement& rejected, const Block& block) {
  switch (rejected.group) {
    case ObservationGroup::kTieImages:
      return fmt::format("tie point {} in {}", rejected.point.value, block.images.at(rejected.image).file);
    case ObservationGroup::kControlImages:
      return fmt::format("{} in {}", block.control.at(rejected.control).name, block.images.at(rejected.image).file);
    case ObservationGroup::kControlPlan:
      return block.control.at(rejected.control).name + ", plan";
    case ObservationGroup::kControlHeight:
      return block.control.at(rejected.control).name + ", height";
    case ObservationGroup::kPositionPlan:
      return "position of " + block.images.at(rejected.image).file + ", plan";
    case ObservationGroup::kPositionHeight:
      return "position of " + block.images.at(rejected.image).file + ", height";
    case ObservationGroup::kAttitudeLevel:
      return "attitude of " + block.images.at(rejected.image).file + ", level";
    case ObservationGroup::kAttitudeHeading:
      return "attitude of " + block.images.at(rejected.image).file + ", heading";
    default:
      return words_of(block.geodetic[rejected.geodetic], block);
  }
}

// Angles are reported in degrees.
bool is_angle(const Rejected& rejected) { return collinea::is_angle(rejected.group); }
const char* unit(const Rejected& rejected) {
  return is_image_point(rejected.group) ? "px" : is_angle(rejected) ? "deg" : "m";
}
double stated_in_unit(const Rejected& rejected, double value) {
  return is_angle(rejected) ? value * 180 / std::numbers::pi : value;
}

const char* axis_of(const Rejected& rejected) {
  constexpr const char* kInImage[] = {"column", "row", ""};
  constexpr const char* kOnGround[] = {"east", "north", "height"};
  constexpr const char* kRotation[] = {"about east", "about north", "about the plumb line"};
  const ObservationSource source = traits_of(rejected.group).source;
  if (source == ObservationSource::kAttitude) return kRotation[rejected.axis];
  if (source == ObservationSource::kGeodetic) return "measured";
  return is_image_point(rejected.group) ? kInImage[rejected.axis] : kOnGround[rejected.axis];
}

std::vector<std::string> names_of(const std::vector<Measurement>& measurements, const Block& block) {
  std::vector<std::string> names;
  for (const Measurement& one : measurements) names.push_back(name_of(one, block));
  return names;
}

std::string inseparable_words(const Snooped& snooped) {
  if (snooped.inseparable.empty()) return "";
  const auto listed = [&](const std::vector<Measurement>& measurements) {
    std::string text;
    for (const std::string& name : names_of(measurements, snooped.block)) text += (text.empty() ? "" : " and ") + name;
    return text;
  };
  std::string html =
      "<p>Which of these is wrong cannot be told: gross errors in the one look like gross errors in the other, "
      "whatever their sizes. Measure one of them again, or others that check them.</p>\n<ul>";
  for (std::size_t i = 0; i < std::min(kMostRows, snooped.inseparable.size()); ++i)
    html += "<li>" + escaped(listed(snooped.inseparable[i].either)) + ", or " +
            escaped(listed(snooped.inseparable[i].or_else)) + "</li>\n";
  return html + "</ul>\n";
}

}  // namespace

std::string words_of_rejected(const Rejected& rejected, const Block& block) {
  std::string text = name_of(rejected, block);
  if (rejected.as_pair) return text + " (the only other ray of the point contradicts it; both went)";
  if (!std::isfinite(rejected.w)) return text + " (not seen there)";
  const int least = is_image_point(rejected.group) ? 2 : is_angle(rejected) ? 5 : 4;
  const int decimals = decimals_for(stated_in_unit(rejected, rejected.sigma), least) - 1;
  const bool in_plan = std::isfinite(rejected.gross_error.x()) && std::isfinite(rejected.gross_error.y());
  const double size = stated_in_unit(
      rejected, in_plan ? rejected.gross_error.head<2>().norm() : std::abs(rejected.gross_error[rejected.axis]));
  if (std::isfinite(size)) text += fmt::format(", off by {:.{}f} {}", size, decimals, unit(rejected));
  return text + fmt::format(" ({} {:+.{}f} {} with a sigma of {:.{}f} {})", axis_of(rejected),
                            stated_in_unit(rejected, rejected.gross_error[rejected.axis]), decimals, unit(rejected),
                            stated_in_unit(rejected, rejected.sigma), decimals + 1, unit(rejected));
}

std::string snooping_section(const AdjustmentReport& report) {
  if (!report.snooped) return "";
  const Snooped& snooped = *report.snooped;
  std::string html = fmt::format(
      "<section><h2>Data snooping</h2>\n<p>{} {} rejected in {}; sigma 0 with all observations was {:.3f}.{}{} Gross "
      "error: measured minus what the adjustment without it says. Influence: by how much the "
      "adjusted value followed it while it took part.</p>\n",
      counted(snooped.rejected.size(), "observation"), snooped.rejected.size() == 1 ? "was" : "were",
      counted(snooped.rounds, "adjustment"), snooped.sigma0_before,
      snooped.finished ? "" : " More are suspect: the bound was reached.",
      snooped.put_back > 0 ? fmt::format(" {} that another gross error had spoilt came back.", snooped.put_back) : "");
  if (!snooped.rejected.empty()) {
    html +=
        "<table><thead><tr><th class=\"l\">observation</th><th class=\"l\">coordinate</th><th>w</th><th>gross "
        "error</th>"
        "<th>&sigma;</th><th>influence</th><th class=\"l\">unit</th><th>redundancy</th></tr></thead><tbody>\n";
    for (std::size_t i = 0; i < std::min(kMostRows, snooped.rejected.size()); ++i) {
      const Rejected& rejected = snooped.rejected[i];
      const int decimals = decimals_for(stated_in_unit(rejected, rejected.sigma), is_image_point(rejected.group) ? 2
                                                                                  : is_angle(rejected)           ? 5
                                                                                                                 : 4);
      html += "<tr>" + text_cell(name_of(rejected, snooped.block)) + text_cell(axis_of(rejected)) +
              cell(rejected.w, 1) + cell(stated_in_unit(rejected, rejected.gross_error[rejected.axis]), decimals) +
              cell(stated_in_unit(rejected, rejected.sigma), decimals) +
              cell(stated_in_unit(rejected, rejected.influence), decimals) + text_cell(unit(rejected)) +
              cell(rejected.redundancy, 2) + "</tr>\n";
    }
    html += "</tbody></table>\n";
    if (snooped.rejected.size() > kMostRows) html += "<p>rejected.csv has more.</p>\n";
  }
  if (!snooped.kept.empty()) {
    html += "<p>Suspect, but they cannot be rejected:</p>\n<ul>";
    for (std::size_t i = 0; i < std::min(kMostRows, snooped.kept.size()); ++i)
      html += "<li>" +
              escaped(name_of(snooped.kept[i].observation, snooped.block) + ": " + words_of(snooped.kept[i].reason)) +
              "</li>\n";
    html += "</ul>\n";
  }
  html += inseparable_words(snooped);
  if (!snooped.with.empty() && !snooped.rejected.empty()) {
    html +=
        "<p>Differences of control and check points with all observations, and now [m]:</p>\n<table><thead><tr><th "
        "class=\"l\">point</th><th>east</th><th>north</th><th>height</th><th>east, now</th><th>north, now</th>"
        "<th>height, now</th></tr></thead><tbody>\n";
    std::vector<double> sigmas;
    for (const ControlDifference& before : snooped.with)
      sigmas.insert(sigmas.end(), before.difference_sigma_m.begin(), before.difference_sigma_m.end());
    const int decimals = decimals_for(sigmas, 4);
    for (const ControlDifference& before : snooped.with) {
      html += "<tr>" + text_cell(snooped.block.control.at(before.point).name);
      for (int axis = 0; axis < 3; ++axis) html += cell(before.difference_m[axis], decimals);
      Eigen::Vector3d now = Eigen::Vector3d::Constant(std::nan(""));
      for (const ControlDifference& after : report.adjusted.control)
        if (after.point == before.point) now = after.difference_m;
      for (int axis = 0; axis < 3; ++axis) html += cell(now[axis], decimals);
      html += "</tr>\n";
    }
    html += "</tbody></table>\n";
  }
  return html + "</section>\n";
}

json snooping_json(const AdjustmentReport& report) {
  const Snooped& snooped = *report.snooped;
  json rejected = json::array(), kept = json::array(), with = json::array();
  for (const Rejected& item : snooped.rejected)
    rejected.push_back(
        {{"observation", name_of(item, snooped.block)},
         {"coordinate", axis_of(item)},
         {"unit", unit(item)},
         {"w", number(item.w)},
         {"gross_error",
          {number(stated_in_unit(item, item.gross_error.x())), number(stated_in_unit(item, item.gross_error.y())),
           number(stated_in_unit(item, item.gross_error.z()))}},
         {"sigma", number(stated_in_unit(item, item.sigma))},
         {"influence", number(stated_in_unit(item, item.influence))},
         {"redundancy", number(item.redundancy)},
         {"as_pair", item.as_pair},
         {"round", item.round}});
  for (const KeptSuspect& one : snooped.kept)
    kept.push_back({{"observation", name_of(one.observation, snooped.block)},
                    {"w", number(one.observation.w)},
                    {"reason", words_of(one.reason)}});
  for (const ControlDifference& one : snooped.with)
    with.push_back({{"name", snooped.block.control.at(one.point).name}, {"difference_m", vector(one.difference_m)}});
  json inseparable = json::array();
  for (const InseparableSets& sets : snooped.inseparable)
    inseparable.push_back(
        {{"either", names_of(sets.either, snooped.block)}, {"or", names_of(sets.or_else, snooped.block)}});
  return {{"adjustments", snooped.rounds}, {"finished", snooped.finished}, {"sigma0_before", snooped.sigma0_before},
          {"rejected", rejected},          {"put_back", snooped.put_back}, {"not_to_be_rejected", kept},
          {"inseparable", inseparable},    {"control_points_before", with}};
}

std::string rejected_csv(const Snooped& snooped) {
  std::string text = "observation,coordinate,unit,w,gross_error,sigma,influence,redundancy,as_pair,adjustment\n";
  const auto value = [](double x) { return std::isfinite(x) ? fmt::format(",{:.10g}", x) : std::string(","); };
  for (const Rejected& rejected : snooped.rejected) {
    text += fmt::format("{},{},{}", in_quotes(name_of(rejected, snooped.block)), axis_of(rejected), unit(rejected));
    for (const double x :
         {rejected.w, stated_in_unit(rejected, rejected.gross_error[rejected.axis]),
          stated_in_unit(rejected, rejected.sigma), stated_in_unit(rejected, rejected.influence), rejected.redundancy})
      text += value(x);
    text += fmt::format(",{},{}\n", rejected.as_pair ? "yes" : "no", rejected.round);
  }
  return text;
}

}  // namespace collinea
