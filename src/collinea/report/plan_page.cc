// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "collinea/report/finding_words.h"
#include "collinea/report/internal/cells.h"
#include "collinea/report/internal/html_page.h"
#include "collinea/report/internal/svg.h"
#include "collinea/report/plan_report.h"
#include "collinea/report/plan_words.h"

namespace collinea {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;
constexpr int kMm = 1;  // decimals of millimetres

double plan_rms(const Eigen::Vector3d& rms_m) { return std::sqrt((rms_m.x() * rms_m.x() + rms_m.y() * rms_m.y()) / 2); }

std::string head(std::initializer_list<const char*> titles) {
  std::string html = "<table><thead><tr>";
  for (const std::string_view title : titles) {
    const bool is_text = title.data() == *titles.begin() || title == "role" || title == "rule";
    html += fmt::format("<th{}>{}</th>", is_text ? " class=\"l\"" : "", title);
  }
  return html + "</tr></thead><tbody>\n";
}

std::string statement(const PlanReport& report) {
  const AreaSigma& area = report.precision.area;
  const auto box = [](const char* name, double value_m, double worst_m) {
    return fmt::format("<div><b>{} mm</b><span>{}; at worst {} mm</span></div>", number_text(1000 * value_m, kMm), name,
                       number_text(1000 * worst_m, kMm));
  };
  if (report.precision.cells.empty())
    return "<div class=\"statement unverified\"><p>No standard deviations can be predicted. " +
           escaped((report.precision.adjusted.undetermined
                        ? sentence_of(*report.precision.adjusted.undetermined, report.precision.planned.block)
                        : "")) +
           "</p></div>\n";
  const bool free = report.precision.adjusted.rank_defect > 0;
  return fmt::format(
      "<div class=\"statement{}\"><p class=\"kind\">{}Expected standard deviation of a well-defined point on the "
      "ground, measured in every image that shows it</p><div class=\"axes\">{}{}</div></div>\n",
      free ? " unverified" : "",
      free ? "Nothing fixes position, attitude or scale on the map: of the shape alone. " : "",
      box("in plan, each axis", plan_rms(area.rms_m), area.worst_plan_m),
      box("in height", area.rms_m.z(), area.worst_height_m));
}

std::string facts(const PlanReport& report) {
  const FlightPlan& plan = report.plan;
  std::string html = "<dl class=\"facts\">";
  const auto fact = [&](const char* name, const std::string& value) {
    html += fmt::format("<div><dt>{}</dt><dd>{}</dd></div>", name, escaped(value));
  };
  fact("site", fmt::format("{:.2f} ha", size_m2(plan.area) / 1e4));
  fact("images", std::to_string(plan.images.size()));
  fact("strips", plan.cross_strips > 0 ? fmt::format("{} and {} across", plan.strips, plan.cross_strips)
                                       : std::to_string(plan.strips));
  fact("height above ground", fmt::format("{:.1f} m", plan.height_m));
  fact("pixel on the ground", fmt::format("{:.1f} mm", 1000 * plan.gsd_m));
  fact("image on the ground", fmt::format("{:.0f} x {:.0f} m", plan.across_m, plan.along_m));
  fact("from image to image", fmt::format("{:.1f} m", plan.base_m));
  fact("from strip to strip", fmt::format("{:.1f} m", plan.spacing_m));
  fact("way to fly", fmt::format("{:.1f} km", plan.path_m / 1000));
  fact("coordinates", report.crs_name.empty() ? "local plane" : report.crs_name);
  return html + "</dl>\n";
}

std::string cautions(const PlanReport& report) {
  std::string html;
  for (const Finding& weak : report.precision.adjusted.weaknesses)
    html += "<li>" + escaped(what_of(weak, report.precision.planned.block)) +
            "<br>Remedy: " + escaped(remedy_of(weak)) + "</li>\n";
  if (report.precision.area.empty > 0)
    html += fmt::format("<li>{} of {} cells of the map {} seen in fewer than two images.</li>\n",
                        report.precision.area.empty, report.precision.area.cells,
                        report.precision.area.empty == 1 ? "is" : "are");
  for (const Custom& custom : report.customs)
    if (!custom.kept) html += "<li>Against custom: not " + escaped(words_of(custom.what)) + ".</li>\n";
  return html.empty() ? "" : "<h2>What the block would determine badly</h2><ul class=\"cautions\">" + html + "</ul>\n";
}

std::string maps(const PlanReport& report) {
  return "<section><h2>Flight and control</h2>\n<figure class=\"map\">" + plan_map(report) +
         "<figcaption>Lines: flight, with the positions of the images. Triangles: control; circles: check points. "
         "Ellipses and "
         "bars: standard deviations (39 % of all errors in plan and 68 % in height lie within) in the scale of the "
         "legend.</figcaption></figure>\n</section><section><h2>Where it is how good</h2>\n<div class=\"pair\"><figure "
         "class=\"map\"><h3>In plan (the worse axis)</h3>" +
         sigma_map(report, false) + "</figure><figure class=\"map\"><h3>In height</h3>" + sigma_map(report, true) +
         "</figure></div>\n<p>Also in sigma.tif (bands east, north, height in metres, images) and "
         "plan.gpkg.</p></section>\n";
}

std::string gains(const PlanReport& report) {
  if (report.gains.empty()) return "";
  std::string html =
      "<section><h2>What more would gain</h2>\n" +
      head({"", "plan [mm]", "plan, worst [mm]", "height [mm]", "height, worst [mm]", "height better by"});
  const AreaSigma& now = report.precision.area;
  const auto row = [&](const std::string& name, const AreaSigma& area) {
    html += "<tr>" + text_cell(name) + cell(1000 * plan_rms(area.rms_m), kMm) + cell(1000 * area.worst_plan_m, kMm) +
            cell(1000 * area.rms_m.z(), kMm) + cell(1000 * area.worst_height_m, kMm) +
            text_cell(&area == &now ? "" : fmt::format("{:.0f} %", 100 * (1 - area.rms_m.z() / now.rms_m.z())), "") +
            "</tr>\n";
  };
  row("as planned", now);
  for (const Gain& gain : report.gains)
    row(gain.position ? fmt::format("{} at {:.1f}, {:.1f}", words_of(gain), gain.position->x(), gain.position->y())
                      : words_of(gain),
        gain.area);
  return html + "</tbody></table></section>\n";
}

std::string check_points(const PlanReport& report) {
  std::string rows;
  for (const ControlDifference& one : report.precision.adjusted.control) {
    const ControlPoint& point = report.precision.planned.block.control.at(one.point);
    if (report.precision.planned.cells.contains(one.point) || !one.covariance_m2) continue;
    rows += "<tr>" + text_cell(point.name) + text_cell(one.used ? "control" : "check") +
            fmt::format("<td>{}</td>", one.rays);
    const Eigen::Vector3d sigma = one.covariance_m2->diagonal().cwiseSqrt();
    for (int i = 0; i < 3; ++i) rows += cell(1000 * sigma[i], kMm);
    for (int i = 0; i < 3; ++i) rows += cell(1000 * point.sigma_m[i], kMm);
    rows += "</tr>\n";
  }
  if (rows.empty()) return "";
  return "<section><h2>Control and check points</h2>\n<p>Standard deviations after the adjustment, and of the "
         "survey.</p>\n" +
         head({"point", "role", "images", "east [mm]", "north [mm]", "height [mm]", "survey east [mm]",
               "survey north [mm]", "survey height [mm]"}) +
         rows + "</tbody></table></section>\n";
}

std::string unknowns(const PlanReport& report) {
  const Precision& precision = report.precision;
  std::string html = "<section><h2>Tie points, images, camera</h2>\n" +
                     head({"tie points of the site", "points", "east [mm]", "north [mm]", "height [mm]"});
  for (const RaysPrecision& rays : precision.rays) {
    const std::string name = rays.to == 0           ? fmt::format("in {} and more images", rays.from)
                             : rays.to == rays.from ? fmt::format("in {} images", rays.from)
                                                    : fmt::format("in {} to {} images", rays.from, rays.to);
    html += "<tr>" + text_cell(name) + fmt::format("<td>{}</td>", rays.points);
    for (int i = 0; i < 3; ++i) html += cell(1000 * rays.rms_m[i], kMm);
    html += "</tr>\n";
  }
  html += "</tbody></table>\n" + head({"images (root mean square)", "x", "y", "z"}) + "<tr>" +
          text_cell("projection centre: east, north, height [mm]");
  for (int i = 0; i < 3; ++i) html += cell(1000 * precision.pose_rms_m[i], kMm);
  html += "</tr>\n<tr>" + text_cell("attitude about the camera's right, down and viewing axis [deg]");
  for (int i = 0; i < 3; ++i) html += cell(kDegrees * precision.rotation_rms_rad[i], 4);
  html += "</tr>\n</tbody></table>\n";
  for (const auto& [id, covariance] : precision.adjusted.camera_covariance) {
    html += head({"camera", "value", "&sigma;", "unit"});
    const Camera& camera = precision.planned.block.cameras.at(id);
    for (const int k : params_of(camera))
      if (covariance(k, k) > 0)
        html += "<tr>" + text_cell(param_name(k)) + cell(camera.params[std::size_t(k)], 2) +
                fmt::format("<td>{:.2g}</td>", std::sqrt(covariance(k, k))) + text_cell(param_unit(k), "") + "</tr>\n";
    html += "</tbody></table>\n";
  }
  return html + "</section>\n";
}

std::string rules(const PlanReport& report) {
  std::string html =
      "<section><h2>Rules of thumb</h2>\n<p>What analytical photogrammetry goes by before a survey; h is the "
      "flying height, mb the photo scale number h / focal length. They know neither control nor overlap, and "
      "come from film measured to &plusmn;6 &micro;m; the adjustment above knows both. After the survey the "
      "real propagation of errors counts.</p>\n" +
      head({"of", "rule", "by the rule [mm]", "by the adjustment [mm]"});
  for (const RuleOfThumb& rule : report.rules)
    html += "<tr>" + text_cell(words_of(rule.rule)) + text_cell(formula_of(rule.rule)) +
            cell(1000 * rule.value_m, kMm) + cell(1000 * rule.predicted_m.value_or(std::nan("")), kMm) + "</tr>\n";
  html += "</tbody></table>\n<ul>";
  for (const Custom& custom : report.customs)
    html += "<li>" + escaped(words_of(custom.what)) + ": " + (custom.kept ? "yes" : "<b>no</b>") + "</li>\n";
  return html + "</ul></section>\n";
}

std::string trials(const PlanReport& report) {
  if (!report.trials) return "";
  const Trials& t = *report.trials;
  return fmt::format(
      "<section><h2>Predicted against simulated errors</h2>\n<p>{} blocks with all errors drawn anew were adjusted. "
      "Root mean "
      "square of error over standard deviation on the map (1 is expected): east {:.3f}, north {:.3f}, height {:.3f}. "
      "Chi-squared over its degrees of freedom: positions {:.3f}, images {:.3f}{}.</p></section>\n",
      t.blocks, t.cell_ratio.x(), t.cell_ratio.y(), t.cell_ratio.z(), t.cell_chi2, t.pose_chi2,
      t.cameras > 0 ? fmt::format(", camera {:.3f}", t.camera_chi2) : "");
}

}  // namespace

std::string plan_page(const PlanReport& report) {
  return whole_page({report.title.empty() ? "Survey" : report.title, "plan", "Planned survey: expected precision", ""},
                    statement(report) + facts(report) + cautions(report) + maps(report) + gains(report) +
                        check_points(report) + unknowns(report) + rules(report) + trials(report) +
                        "<footer>Predicted by the bundle adjustment of the planned block. Gross errors, poor texture, "
                        "motion blur and "
                        "a bad camera model come on top. All figures are also in plan.json.</footer>\n");
}

}  // namespace collinea
