// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/absolute_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "collinea/io/text.h"
#include "collinea/report/findings_text.h"

namespace collinea {
namespace {

constexpr const char* kAxes[] = {"X", "Y", "Z"};

bool is_known(const AbsoluteReport& report, const AbsoluteReport::Point& point, int axis) {
  return axis < 2 ? point.has_plan : point.has_height && !report.is_plane;
}

TextTable residuals_table(const AbsoluteReport& report) {
  TextTable table;
  const int axes = report.is_plane ? 2 : 3;
  table.columns = {{"point", ""}};
  for (int axis = 0; axis < axes; ++axis) table.columns.push_back({fmt::format("d{}", kAxes[axis]), "m"});
  for (const char* what : {"w_", "r_"})
    for (int axis = 0; axis < axes; ++axis) table.columns.push_back({fmt::format("{}{}", what, kAxes[axis]), ""});
  table.columns.push_back({"role", ""});
  for (const AbsoluteReport::Point& point : report.points) {
    std::vector<std::string> row{point.name};
    const bool is_used = !point.is_check && !point.is_rejected;
    const auto add = [&](const Eigen::Vector3d& values, int decimals, bool wanted) {
      for (int axis = 0; axis < axes; ++axis)
        row.push_back(wanted && is_known(report, point, axis) ? decimal_text(values[axis], decimals) : "-");
    };
    add(point.misfit, 4, true);
    add(point.w, 2, is_used || !report.is_plane);
    add(point.redundancy, 2, is_used);
    row.push_back(point.is_check ? "check" : point.is_rejected ? "rejected" : "control");
    table.rows.push_back(std::move(row));
  }
  return table;
}

TextTable ground_table(const AbsoluteReport& report) {
  TextTable table;
  const int axes = report.is_plane ? 2 : 3;
  table.columns = {{"point", ""}};
  for (int axis = 0; axis < axes; ++axis) table.columns.push_back({kAxes[axis], "m"});
  for (int axis = 0; axis < axes; ++axis) table.columns.push_back({fmt::format("sigma_{}", kAxes[axis]), "m"});
  for (const AbsoluteReport::Ground& point : report.ground) {
    std::vector<std::string> row{point.name};
    for (int axis = 0; axis < axes; ++axis) row.push_back(decimal_text(point.position[axis], 5));
    for (int axis = 0; axis < axes; ++axis) row.push_back(sigma_text(point.sigma[axis]));
    table.rows.push_back(std::move(row));
  }
  return table;
}

// The component with the largest test, where it is beyond the limit.
std::string suspect_text(const AbsoluteReport& report) {
  const AbsoluteReport::Point* worst = nullptr;
  int at = 0;
  std::size_t tests = 0;
  for (const AbsoluteReport::Point& point : report.points)
    for (int axis = 0; axis < 3; ++axis)
      if (!point.is_check && !point.is_rejected && is_known(report, point, axis))
        if (tests += point.w[axis] != 0; !worst || std::abs(point.w[axis]) > std::abs(worst->w[at])) {
          worst = &point;
          at = axis;
        }
  if (!worst || report.variance.redundancy <= 0) return "";
  const double limit = report.variance.limit(tests);
  if (std::abs(worst->w[at]) <= limit)
    return fmt::format("no control coordinate contradicts the others: largest |w| {:.2f} ({} of {}), limit {:.2f}\n",
                       std::abs(worst->w[at]), kAxes[at], worst->name, limit);
  return fmt::format(
      "{} of point {} has the largest |w|: {:.2f}, limit {:.2f}; an error of about {} m would explain it\n", kAxes[at],
      worst->name, std::abs(worst->w[at]), limit,
      decimal_text(worst->misfit[at] / std::max(worst->redundancy[at], 1e-3), 3));
}

std::string method_text(const AbsoluteReport& report) {
  if (report.is_plane) return "plane similarity, 4 parameters: X = X0 + scale R(angle) U";
  if (!report.closed_form.empty())
    return fmt::format(
        "absolute orientation, method {}: all points of equal weight, standard deviations by propagation",
        report.closed_form);
  return fmt::format("absolute orientation by least squares, 7 parameters, {} iterations", report.iterations);
}

std::string control_text(const AbsoluteReport& report) {
  std::string text =
      fmt::format("control: {} full, {} in plan only, {} in height only", report.full, report.plan, report.height);
  if (report.is_plane) return fmt::format("control: {}\n", counted_text(std::size_t(report.full), "point"));
  return text + "\n";
}

// Root mean square of each component over the points that pass.
template <class Passes>
std::string rms_text(const AbsoluteReport& report, const char* what, const Passes& passes) {
  std::string text;
  std::size_t points = 0;
  for (const AbsoluteReport::Point& point : report.points) points += passes(point);
  for (int axis = 0; axis < (report.is_plane ? 2 : 3); ++axis) {
    double squares = 0, count = 0;
    for (const AbsoluteReport::Point& point : report.points)
      if (passes(point) && is_known(report, point, axis)) {
        squares += point.misfit[axis] * point.misfit[axis];
        count += 1;
      }
    if (count > 0) text += fmt::format("  {} {}", kAxes[axis], metres_text(std::sqrt(squares / count)));
  }
  return points ? fmt::format("RMS of {} {}:{}\n", points, what, text) : "";
}

}  // namespace

std::string absolute_text(const AbsoluteReport& report) {
  std::string text = method_text(report) + "\n" + control_text(report);
  text += variance_text(report.variance);
  text += estimates_text(report.parameters);
  if (!report.inverse_parameters.empty()) text += "inverse:\n" + estimates_text(report.inverse_parameters);
  if (report.covariance.size()) text += correlations_text(report.parameters, report.covariance);
  text += "differences, given minus computed:\n" + indented_rows(residuals_table(report));
  text += rms_text(report, "control points", [](const auto& p) { return !p.is_check && !p.is_rejected; });
  text += rms_text(report, "check points", [](const auto& p) { return p.is_check; });
  text += suspect_text(report);
  for (const AbsoluteReport::Point& point : report.points)
    if (point.is_rejected)
      text += fmt::format("point {} contradicts the others and takes no part: it is off by {}\n", point.name,
                          metres_text(point.misfit.norm()));
  if (report.solutions > 1)
    text += fmt::format("of {} orientations this one tilts the model least\n", report.solutions);
  return text + findings_text(report.findings);
}

std::vector<NamedTable> absolute_tables(const AbsoluteReport& report) {
  std::vector<NamedTable> tables{{"parameters.txt", estimates_table(report.parameters)},
                                 {"residuals.txt", residuals_table(report)},
                                 {"ground.txt", ground_table(report)}};
  if (report.covariance.size())
    tables.push_back({"correlations.txt", correlations_table(report.parameters, report.covariance)});
  return tables;
}

}  // namespace collinea
