// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "collinea/report/finding_words.h"
#include "collinea/report/internal/counted.h"
#include "collinea/report/internal/finding_json.h"
#include "collinea/report/json_values.h"
#include "collinea/report/plan_report.h"
#include "collinea/report/plan_words.h"

namespace collinea {
namespace {

using json = nlohmann::ordered_json;

json position(const Eigen::Vector2d& at) { return {at.x(), at.y()}; }

json area_json(const AreaSigma& area) {
  return {{"rms_m", vector(area.rms_m)},
          {"worst_plan_m", number(area.worst_plan_m)},
          {"worst_plan_at", position(area.worst_plan_at)},
          {"worst_height_m", number(area.worst_height_m)},
          {"worst_height_at", position(area.worst_height_at)},
          {"cells", area.cells},
          {"cells_seen_in_fewer_than_two_images", area.empty}};
}

json flight_json(const FlightPlan& plan) {
  return {{"images", plan.images.size()},
          {"strips", plan.strips},
          {"cross_strips", plan.cross_strips},
          {"height_m", plan.height_m},
          {"gsd_m", plan.gsd_m},
          {"image_m", {plan.across_m, plan.along_m}},
          {"base_m", plan.base_m},
          {"strip_spacing_m", plan.spacing_m},
          {"heading_deg", plan.heading_rad * 180 / std::numbers::pi},
          {"path_m", plan.path_m},
          {"area_m2", size_m2(plan.area)}};
}

json points_json(const PlanReport& report) {
  json list = json::array();
  for (const ControlDifference& one : report.precision.adjusted.control) {
    if (report.precision.planned.cells.contains(one.point) || !one.covariance_m2) continue;
    const ControlPoint& point = report.precision.planned.block.control.at(one.point);
    list.push_back({{"name", point.name},
                    {"role", one.used ? "control" : "check"},
                    {"images", one.rays},
                    {"position", position(point.position_in_map.head<2>())},
                    {"sigma_m", vector(one.covariance_m2->diagonal().cwiseSqrt())},
                    {"survey_sigma_m", vector(point.sigma_m)}});
  }
  return list;
}

json cameras_json(const Precision& precision) {
  json list = json::array();
  for (const auto& [id, covariance] : precision.adjusted.camera_covariance) {
    json sigmas = json::object();
    const Camera& camera = precision.planned.block.cameras.at(id);
    for (const int k : params_of(camera))
      if (covariance(k, k) > 0) sigmas[param_name(k)] = number(std::sqrt(covariance(k, k)));
    list.push_back({{"name", camera.name}, {"sigma", sigmas}});
  }
  return list;
}

double plan_rms(const Eigen::Vector3d& rms_m) { return std::sqrt((rms_m.x() * rms_m.x() + rms_m.y() * rms_m.y()) / 2); }

}  // namespace

std::string plan_json(const PlanReport& report) {
  const Precision& precision = report.precision;
  json j = {
      {"flight", flight_json(report.plan)},
      {"crs", report.crs_name},
      {"datum", words_of(precision.adjusted.datum, precision.adjusted.rank_defect)},
      {"rank_defect", precision.adjusted.rank_defect},
      {"redundancy", precision.adjusted.redundancy},
      {"undetermined", precision.adjusted.undetermined
                           ? finding_json(*precision.adjusted.undetermined, precision.planned.block)
                           : json(nullptr)},
      {"area", area_json(precision.area)},
      {"points", points_json(report)},
      {"tie_points", json::array()},
      {"images",
       {{"centre_rms_m", vector(precision.pose_rms_m)}, {"rotation_rms_rad", vector(precision.rotation_rms_rad)}}},
      {"cameras", cameras_json(precision)},
      {"gains", json::array()},
      {"rules_of_thumb", json::array()},
      {"customs", json::array()},
      {"weaknesses", json::array()}};
  for (const RaysPrecision& rays : precision.rays)
    j["tie_points"].push_back({{"images_from", rays.from},
                               {"images_to", rays.to > 0 ? json(rays.to) : json(nullptr)},
                               {"points", rays.points},
                               {"rms_m", vector(rays.rms_m)}});
  for (const Gain& gain : report.gains)
    j["gains"].push_back({{"what", words_of(gain)},
                          {"position", gain.position ? position(*gain.position) : json(nullptr)},
                          {"area", area_json(gain.area)}});
  for (const RuleOfThumb& rule : report.rules)
    j["rules_of_thumb"].push_back({{"of", words_of(rule.rule)},
                                   {"rule", formula_of(rule.rule)},
                                   {"by_rule_m", rule.value_m},
                                   {"by_adjustment_m", number(rule.predicted_m.value_or(std::nan("")))}});
  for (const Custom& custom : report.customs)
    j["customs"].push_back({{"what", words_of(custom.what)}, {"kept", custom.kept}});
  j["weaknesses"] = findings_json(precision.adjusted.weaknesses, report.precision.planned.block);
  if (report.trials)
    j["trials"] = {{"blocks", report.trials->blocks},
                   {"ratio", vector(report.trials->cell_ratio)},
                   {"chi2_places", number(report.trials->cell_chi2)},
                   {"chi2_images", number(report.trials->pose_chi2)},
                   {"chi2_camera", number(report.trials->camera_chi2)}};
  return j.dump(2, ' ', false, json::error_handler_t::replace) + "\n";
}

std::string plan_text(const PlanReport& report) {
  const FlightPlan& plan = report.plan;
  const AreaSigma& area = report.precision.area;
  const auto control = std::count_if(report.points.begin(), report.points.end(),
                                     [](const auto& point) { return point.role == ControlRole::kControl; });
  std::string text = fmt::format(
      "flight     {} in {}{}, {:.1f} m above ground, pixel {:.1f} mm, {:.1f} km to fly\n"
      "           an image every {:.1f} m, strips {:.1f} m apart, {}\n",
      counted(plan.images.size(), "image"), counted(plan.strips, "strip"),
      plan.cross_strips > 0 ? fmt::format(" and {} across", plan.cross_strips) : "", plan.height_m, 1000 * plan.gsd_m,
      plan.path_m / 1000, plan.base_m, plan.spacing_m, counted(control, "control point"));
  if (report.precision.cells.empty())
    return text + "expected   nothing. " +
           (report.precision.adjusted.undetermined
                ? sentence_of(*report.precision.adjusted.undetermined, report.precision.planned.block)
                : "") +
           "\n";
  const auto sigmas = [](const AreaSigma& its) {
    return fmt::format("plan {:.1f} mm (worst {:.1f}), height {:.1f} mm (worst {:.1f})", 1000 * plan_rms(its.rms_m),
                       1000 * its.worst_plan_m, 1000 * its.rms_m.z(), 1000 * its.worst_height_m);
  };
  text += (report.precision.adjusted.rank_defect > 0 ? "shape      " : "expected   ") + sigmas(area) +
          ": standard deviation of a well-defined point\n";
  if (report.precision.adjusted.rank_defect > 0)
    text += "           of the shape alone: position, attitude or scale on the map are not fixed (see weak)\n";
  for (const Gain& gain : report.gains)
    text += "with       " + sigmas(gain.area) + ": " + words_of(gain) +
            (gain.position ? fmt::format(" at {:.1f}, {:.1f}", gain.position->x(), gain.position->y()) : "") + "\n";
  for (const RuleOfThumb& rule : report.rules)
    if (rule.predicted_m)
      text += fmt::format("rule       {:.1f} mm, here {:.1f} mm: {} = {}\n", 1000 * rule.value_m,
                          1000 * *rule.predicted_m, words_of(rule.rule), formula_of(rule.rule));
  if (report.trials)
    text += fmt::format(
        "simulated  errors of {} blocks over what was predicted: east {:.2f}, north {:.2f}, height {:.2f}\n",
        report.trials->blocks, report.trials->cell_ratio.x(), report.trials->cell_ratio.y(),
        report.trials->cell_ratio.z());
  for (const Finding& weak : report.precision.adjusted.weaknesses)
    text += "weak       " + sentence_of(weak, report.precision.planned.block) + "\n";
  for (const Custom& custom : report.customs)
    if (!custom.kept) text += fmt::format("custom     not {}\n", words_of(custom.what));
  if (area.empty > 0)
    text += fmt::format("seen       {} of {} cells of the map {} in fewer than two images\n", area.empty, area.cells,
                        area.empty == 1 ? "is" : "are");
  return text;
}

}  // namespace collinea
