// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/monoplot_report.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

namespace collinea {
namespace {

std::string outcome_of(const MonoplotReport::Point& point) {
  return point.is_oriented ? std::string(word_of(point.found.outcome)) : "not_oriented";
}

std::string_view reason_of(MonoplotOutcome outcome) {
  for (const auto& entry : words(outcome))
    if (entry.value == outcome) return entry.meaning;
  return "";
}

bool is_found(const MonoplotReport::Point& point) {
  return point.is_oriented && point.found.outcome == MonoplotOutcome::kFound;
}

TextTable points_table(const MonoplotReport& report, bool in_full) {
  TextTable table;
  table.columns = {{"point", ""}, {"image", ""}, {"outcome", ""}};
  for (const char* name : {"X", "Y", "Z", "sigma_X", "sigma_Y", "sigma_Z"}) table.columns.push_back({name, "m"});
  if (in_full)
    for (const char* name : {"correlation_XY", "correlation_XZ", "correlation_YZ"}) table.columns.push_back({name, ""});
  table.columns.push_back({"sigma_height", "m"});
  table.columns.push_back({"angle", "deg"});
  for (const MonoplotReport::Point& point : report.points) {
    std::vector<std::string> row{point.name, point.image, outcome_of(point)};
    if (!is_found(point)) {
      row.resize(table.columns.size(), "-");
      table.rows.push_back(std::move(row));
      continue;
    }
    const Eigen::Matrix3d& c = point.found.covariance;
    const Eigen::Vector3d sigma = c.diagonal().cwiseMax(0).cwiseSqrt();
    for (int axis = 0; axis < 3; ++axis) row.push_back(decimal_text(point.found.position[axis], 4));
    for (int axis = 0; axis < 3; ++axis)
      row.push_back(std::isfinite(c(axis, axis)) ? decimal_text(sigma[axis], 4) : "-");
    if (in_full)
      for (const auto& [a, b] : {std::pair(0, 1), std::pair(0, 2), std::pair(1, 2)})
        row.push_back(decimal_text(c(a, b) / (sigma[a] * sigma[b]), 6));
    row.push_back(decimal_text(point.found.height_sigma_m, 4));
    row.push_back(decimal_text(point.found.angle_rad * 180 / std::numbers::pi, 2));
    table.rows.push_back(std::move(row));
  }
  return table;
}

}  // namespace

std::string monoplot_text(const MonoplotReport& report) {
  std::size_t found = 0, without_sigma = 0;
  for (const MonoplotReport::Point& point : report.points) {
    found += is_found(point);
    without_sigma += is_found(point) && std::isnan(point.found.height_sigma_m);
  }
  std::string text = fmt::format("{} of {} rays meet the surface\n", found, report.points.size());
  if (!report.orientations_have_sigmas) text += "orientations taken as exact: they state no sigmas\n";
  if (!report.heights_have_sigmas) text += "heights taken as exact: they state no sigmas\n";
  if (without_sigma)
    text += fmt::format("{} without standard deviations: the surface states none there\n",
                        counted_text(without_sigma, "point"));
  text += indented_rows(points_table(report, false));
  for (const MonoplotReport::Point& point : report.points)
    if (!point.is_oriented)
      text += fmt::format("point {}: no orientation of image {}\n", point.name, point.image);
    else if (!is_found(point))
      text += fmt::format("point {} of {}: {}\n", point.name, point.image, reason_of(point.found.outcome));
  return text;
}

std::vector<NamedTable> monoplot_tables(const MonoplotReport& report) {
  return {{"points.txt", points_table(report, true)}};
}

}  // namespace collinea
