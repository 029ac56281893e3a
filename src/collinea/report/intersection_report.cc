// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/intersection_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "collinea/io/text.h"

namespace collinea {
namespace {

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

std::string suspect_text(const IntersectionReport& report) {
  std::string text;
  const double limit = report.variance.limit();
  for (const IntersectionReport::Point& point : report.points) {
    const IntersectionReport::Ray* worst = nullptr;
    for (const IntersectionReport::Ray& ray : point.rays)
      if (!worst || ray.w.cwiseAbs().maxCoeff() > worst->w.cwiseAbs().maxCoeff()) worst = &ray;
    if (!worst || worst->w.cwiseAbs().maxCoeff() <= limit) continue;
    text += point.rays.size() == 2
                ? fmt::format(
                      "point {}: its two rays do not meet (|w| {:.1f}, limit {:.2f}); two rays do not tell which "
                      "is wrong\n",
                      point.name, worst->w.cwiseAbs().maxCoeff(), limit)
                : fmt::format("point {}: the ray of image {} contradicts the others (|w| {:.1f}, limit {:.2f})\n",
                              point.name, worst->image, worst->w.cwiseAbs().maxCoeff(), limit);
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
  for (const IntersectionReport::Point& point : report.points)
    if (!point.is_found)
      text +=
          point.rays_given < 2
              ? fmt::format("point {} is seen in one oriented image: no depth\n", point.name)
              : fmt::format("point {} has no position: its rays are parallel or meet behind a camera\n", point.name);
  return text + suspect_text(report);
}

std::vector<NamedTable> intersection_tables(const IntersectionReport& report) {
  return {{"points.txt", points_table(report)}, {"residuals.txt", rays_table(report)}};
}

}  // namespace collinea
