// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/measured_report.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <numbers>

namespace collinea {
namespace {

constexpr double kLimit = 3.29;  // of w, which chance exceeds once in a thousand
constexpr double kDegrees = 180 / std::numbers::pi;

std::size_t images_of(const MeasuredReport::Point& point) {
  std::size_t count = 0;
  for (const MeasuredReport::Mark& mark : point.marks) count += mark.is_oriented;
  return count;
}

TextTable points_table(const MeasuredReport& report, bool in_full) {
  TextTable table;
  table.columns = {{"point", ""}, {"images", ""}};
  const bool in_map = !report.crs.empty();
  const std::array<std::string, 3> axes =
      in_map ? std::array<std::string, 3>{"E", "N", "H"} : std::array<std::string, 3>{"X", "Y", "Z"};
  for (const std::string& axis : axes) table.columns.push_back({axis, "m"});
  for (const std::string& axis : axes) table.columns.push_back({"sigma_" + axis, "m"});
  if (in_full)
    for (const auto& [a, b] : {std::pair(0, 1), std::pair(0, 2), std::pair(1, 2)})
      table.columns.push_back({"correlation_" + axes[std::size_t(a)] + axes[std::size_t(b)], ""});
  for (const MeasuredReport::Point& point : report.points) {
    std::vector<std::string> row{point.name, std::to_string(images_of(point))};
    if (point.position) {
      const Eigen::Matrix3d& c = point.covariance;
      const Eigen::Vector3d sigma = c.diagonal().cwiseMax(0).cwiseSqrt();
      for (int axis = 0; axis < 3; ++axis) row.push_back(decimal_text((*point.position)[axis], 4));
      for (int axis = 0; axis < 3; ++axis) row.push_back(decimal_text(sigma[axis], 4));
      if (in_full)
        for (const auto& [a, b] : {std::pair(0, 1), std::pair(0, 2), std::pair(1, 2)})
          row.push_back(decimal_text(c(a, b) / (sigma[a] * sigma[b]), 4));
    }
    row.resize(table.columns.size(), "-");
    table.rows.push_back(std::move(row));
  }
  return table;
}

TextTable marks_table(const MeasuredReport& report) {
  TextTable table;
  table.columns = {{"point", ""},
                   {"image", ""},
                   {"residual_x", "px"},
                   {"residual_y", "px"},
                   {"w_x", ""},
                   {"w_y", ""},
                   {"redundancy_x", ""},
                   {"redundancy_y", ""},
                   {"minimal_detectable_bias_x", "px"},
                   {"minimal_detectable_bias_y", "px"}};
  for (const MeasuredReport::Point& point : report.points)
    for (const MeasuredReport::Mark& mark : point.marks) {
      std::vector<std::string> row{point.name, mark.image};
      for (const auto& [values, decimals] :
           {std::pair(mark.test.residual_px, 3), std::pair(mark.test.w, 2), std::pair(mark.test.redundancy, 3),
            std::pair(mark.test.minimal_detectable_bias_px, 2)})
        for (int axis = 0; axis < 2; ++axis)
          row.push_back(point.position && mark.is_oriented ? decimal_text(values[axis], decimals) : "-");
      table.rows.push_back(std::move(row));
    }
  return table;
}

bool is_angle(FigureKind kind) { return unit_of(kind) == "rad"; }
std::string shown_unit(FigureKind kind) { return is_angle(kind) ? "deg" : std::string(unit_of(kind)); }

// The worst mark beyond the limit, and what has no position.
std::string remarks_of(const MeasuredReport::Point& point) {
  std::string text;
  for (const MeasuredReport::Mark& mark : point.marks)
    if (!mark.is_oriented) text += fmt::format("point {}: image {} is not oriented\n", point.name, mark.image);
  if (!point.position)
    return text +
           fmt::format("point {}: its marks do not determine it: two images from different positions do\n", point.name);
  const MeasuredReport::Mark* worst = nullptr;
  double largest = kLimit;
  for (const MeasuredReport::Mark& mark : point.marks)
    for (int axis = 0; axis < 2; ++axis)
      if (std::abs(mark.test.w[axis]) > largest) {
        worst = &mark;
        largest = std::abs(mark.test.w[axis]);
      }
  if (worst)
    text += fmt::format(
        "point {}: its mark in {} contradicts the others: residual {:.2f}, {:.2f} px, test {:.1f} "
        "(limit {})\n",
        point.name, worst->image, worst->test.residual_px.x(), worst->test.residual_px.y(), largest, kLimit);
  return text;
}

}  // namespace

std::vector<NamedTable> figure_tables(std::span<const MeasuredReport::Figure> figures) {
  if (figures.empty()) return {};
  TextTable table;
  table.columns = {{"figure", ""}, {"points", ""}, {"value", ""}, {"sigma", ""}, {"unit", ""}};
  for (const MeasuredReport::Figure& figure : figures) {
    const double factor = is_angle(figure.kind) ? kDegrees : 1;
    std::vector<std::string> row{std::string(word_of(figure.kind)), fmt::format("{}", fmt::join(figure.points, "-"))};
    if (figure.measured)
      row.insert(row.end(),
                 {decimal_text(factor * figure.measured->value, 6), decimal_text(factor * figure.measured->sigma, 6)});
    row.resize(4, "-");
    row.push_back(shown_unit(figure.kind));
    table.rows.push_back(std::move(row));
  }
  return {{"figures.txt", std::move(table)}};
}

std::string figures_text(std::span<const MeasuredReport::Figure> figures) {
  std::vector<Estimate> estimates;
  std::string missing;
  for (const MeasuredReport::Figure& figure : figures) {
    const std::string name = fmt::format("{} {}", word_of(figure.kind), fmt::join(figure.points, " "));
    const double factor = is_angle(figure.kind) ? kDegrees : 1;
    if (figure.measured)
      estimates.push_back(
          {name, shown_unit(figure.kind), factor * figure.measured->value, factor * figure.measured->sigma});
    else
      missing += fmt::format(
          "{}: {}\n", name,
          figure.undetermined.empty() ? figure.refused : "point " + figure.undetermined + " is not determined");
  }
  return (estimates.empty() ? "" : "\n" + estimates_text(estimates)) + missing;
}

std::string measured_text(const MeasuredReport& report) {
  std::size_t determined = 0;
  for (const MeasuredReport::Point& point : report.points) determined += point.position.has_value();
  std::string text = fmt::format("{} of {} determined, {}; sigma0 of the block {:.2f}\n", determined,
                                 counted_text(report.points.size(), "point"),
                                 report.crs.empty() ? "in the frame of the block" : "in " + report.crs, report.sigma0);
  if (!report.is_placed)
    text += "nothing gives the block position, attitude and scale: sigmas are those of its shape\n";
  text += indented_rows(points_table(report, false));
  for (const MeasuredReport::Point& point : report.points) text += remarks_of(point);
  return text + figures_text(report.figures);
}

std::vector<NamedTable> measured_tables(const MeasuredReport& report) {
  std::vector<NamedTable> tables{{"points.txt", points_table(report, true)}, {"marks.txt", marks_table(report)}};
  for (NamedTable& figures : figure_tables(report.figures)) tables.push_back(std::move(figures));
  return tables;
}

}  // namespace collinea
