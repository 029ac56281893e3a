// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/intersection_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "collinea/io/text.h"
#include "collinea/math/fisher.h"
#include "collinea/report/findings_text.h"

namespace collinea {
namespace {

// How likely the test of the rays is so large or larger when they meet.
double rays_meet_chance(const MultiImagePoint& match) {
  return match.redundancy > 0 ? fisher_tail(match.statistic / match.redundancy, match.redundancy,
                                            std::numeric_limits<double>::infinity())
                              : 1;
}

TextTable points_table(const IntersectionReport& report) {
  TextTable table;
  table.columns = {{"point", ""}};
  for (const char* name : {"X", "Y", "Z", "sigma_X", "sigma_Y", "sigma_Z"}) table.columns.push_back({name, "m"});
  for (const char* name : {"rays", "sigma0"}) table.columns.push_back({name, ""});
  table.columns.push_back({"angle", "deg"});
  const bool has_ground = std::any_of(report.points.begin(), report.points.end(),
                                      [](const IntersectionReport::Point& point) { return point.has_ground; });
  if (has_ground)
    for (const char* name : {"dX", "dY", "dZ"}) table.columns.push_back({name, "m"});
  for (const IntersectionReport::Point& point : report.points) {
    if (!point.is_found) continue;
    std::vector<std::string> row{point.name};
    for (int axis = 0; axis < 3; ++axis) row.push_back(decimal_text(point.position[axis], 4));
    for (int axis = 0; axis < 3; ++axis) row.push_back(decimal_text(point.sigma[axis], 4));
    row.push_back(std::to_string(point.rays.size()));
    row.push_back(decimal_text(point.sigma0, 2));
    row.push_back(decimal_text(point.max_angle_rad * 180 / std::numbers::pi, 1));
    if (has_ground)
      for (int axis = 0; axis < 3; ++axis)
        row.push_back(point.has_ground ? decimal_text(point.off_ground[axis], 4) : "-");
    table.rows.push_back(std::move(row));
  }
  return table;
}

TextTable rays_table(const IntersectionReport& report) {
  TextTable table;
  table.columns = {{"point", ""}, {"image", ""}, {"dx", report.unit}, {"dy", report.unit}};
  for (const char* name : {"w_x", "w_y", "r_x", "r_y"}) table.columns.push_back({name, ""});
  const int decimals = report.unit == "mm" ? 5 : 3;
  for (const IntersectionReport::Point& point : report.points)
    for (const IntersectionReport::Ray& ray : point.rays)
      table.rows.push_back({point.name, ray.image, decimal_text(ray.misfit.x(), decimals),
                            decimal_text(ray.misfit.y(), decimals), decimal_text(ray.w.x(), 2),
                            decimal_text(ray.w.y(), 2), decimal_text(ray.redundancy.x(), 2),
                            decimal_text(ray.redundancy.y(), 2)});
  return table;
}

TextTable refined_table(const IntersectionReport& report) {
  TextTable table;
  table.columns = {{"point", ""}, {"reference", ""}};
  for (const char* name : {"X", "Y", "Z", "sigma_X", "sigma_Y", "sigma_Z"}) table.columns.push_back({name, "m"});
  table.columns.insert(table.columns.end(), {{"images", ""}, {"noise", "grey"}, {"test", ""}, {"chance", ""}});
  for (const char* name : {"moved_X", "moved_Y", "moved_Z"}) table.columns.push_back({name, "m"});
  const bool has_ground = std::any_of(report.refined.begin(), report.refined.end(),
                                      [](const IntersectionReport::Refined& point) { return point.has_ground; });
  if (has_ground)
    for (const char* name : {"dX", "dY", "dZ"}) table.columns.push_back({name, "m"});
  for (const IntersectionReport::Refined& point : report.refined) {
    const MultiImagePoint& match = point.match;
    if (match.outcome != MultiImageOutcome::kFound) continue;
    std::vector<std::string> row{point.name, point.reference};
    const auto add = [&](const Eigen::Vector3d& values) {
      for (int axis = 0; axis < 3; ++axis) row.push_back(decimal_text(values[axis], 4));
    };
    add(match.point_in_world);
    add(match.covariance.diagonal().cwiseSqrt());
    row.push_back(std::to_string(
        1 + std::count_if(match.views.begin(), match.views.end(), [](const WindowInView& v) { return v.is_used; })));
    row.push_back(decimal_text(match.noise_grey, 1));
    row.push_back(decimal_text(match.statistic, 1));
    row.push_back(decimal_text(rays_meet_chance(match), 4));
    add(point.moved);
    if (has_ground) add(point.has_ground ? point.off_ground : Eigen::Vector3d::Constant(NAN));
    table.rows.push_back(std::move(row));
  }
  return table;
}

TextTable windows_table(const IntersectionReport& report) {
  TextTable table;
  table.columns = {{"point", ""}, {"image", ""}, {"x", "px"}, {"y", "px"}};
  table.columns.insert(table.columns.end(),
                       {{"correlation", ""}, {"gain", ""}, {"offset", "grey"}, {"alone_dx", "px"}, {"alone_dy", "px"}});
  for (const char* name : {"a_xx", "a_xy", "a_yx", "a_yy"}) table.columns.push_back({name, ""});
  for (const IntersectionReport::Refined& point : report.refined) {
    if (point.match.outcome != MultiImageOutcome::kFound) continue;
    for (std::size_t i = 0; i < point.images.size(); ++i) {
      const WindowInView& view = point.match.views[i];
      if (!view.is_used && point.images[i] != point.reference) continue;
      std::vector<std::string> row{point.name, point.images[i]};
      for (const double value : {view.pixel.x(), view.pixel.y(), view.correlation, view.gain, view.offset_grey,
                                 view.misclosure_px.x(), view.misclosure_px.y()})
        row.push_back(decimal_text(value, 3));
      for (int k = 0; k < 4; ++k) row.push_back(decimal_text(view.px_from_reference(k / 2, k % 2), 4));
      table.rows.push_back(std::move(row));
    }
  }
  return table;
}

constexpr double kRaysMiss = 0.001;  // chance below which rays do not meet

std::string refined_text(const IntersectionReport& report) {
  if (report.refined.empty()) return {};
  const TextTable table = refined_table(report);
  std::string text =
      fmt::format("matched in all images: {} of {}\n", table.rows.size(), counted_text(report.refined.size(), "point"));
  text += indented_rows(table);
  for (const IntersectionReport::Refined& point : report.refined)
    if (point.match.outcome != MultiImageOutcome::kFound) {
      std::string_view why;
      for (const auto& word : words(point.match.outcome))
        if (word.value == point.match.outcome) why = word.meaning;
      text += fmt::format("point {} was not matched: {}\n", point.name, why);
    } else if (rays_meet_chance(point.match) < kRaysMiss) {
      text += fmt::format(
          "point {}: its windows do not lie where all rays meet (test {:.1f}, {} degrees of freedom): orientations are "
          "worse than stated, or an image shows something else\n",
          point.name, point.match.statistic, point.match.redundancy);
    }
  return text;
}

}  // namespace

std::string intersection_text(const IntersectionReport& report) {
  const auto found = static_cast<std::size_t>(
      std::count_if(report.points.begin(), report.points.end(), [](const auto& point) { return point.is_found; }));
  std::string text = fmt::format("intersection of rays: {}; orientations {}\n", counted_text(found, "point"),
                                 report.orientations_have_sigmas ? "with their sigmas" : "taken as exact");
  text += variance_text(report.variance) + indented_rows(points_table(report));
  text += "residuals, measured minus computed:\n" + indented_rows(rays_table(report));
  return text + refined_text(report) + findings_text(report.findings);
}

std::vector<NamedTable> intersection_tables(const IntersectionReport& report) {
  std::vector<NamedTable> tables{{"points.txt", points_table(report)}, {"residuals.txt", rays_table(report)}};
  if (!report.refined.empty()) {
    tables.push_back({"refined.txt", refined_table(report)});
    tables.push_back({"windows.txt", windows_table(report)});
  }
  return tables;
}

}  // namespace collinea
