// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/correlate_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "collinea/math/median.h"
#include "collinea/report/internal/svg.h"
#include "collinea/report/single_step.h"

namespace collinea {
namespace {

using Eigen::Vector2d;

constexpr std::size_t kShown = 10;  // rows on the screen
constexpr double kMapSide = 360, kChartWidth = 380, kChartHeight = 190;

TextTable rows_of(const CorrelateReport& report, std::size_t most) {
  TextTable table;
  table.columns = {{"point", ""},          {"x_left", "px"},
                   {"y_left", "px"},       {"outcome", ""},
                   {"x_right", "px"},      {"y_right", "px"},
                   {"sigma_x", "px"},      {"sigma_y", "px"},
                   {"correlation_xy", ""}, {std::string(word_of(report.options.method)), ""},
                   {"returned", "px"},     {"candidates", ""}};
  if (report.is_relaxed) table.columns.push_back({"probability", ""});
  for (std::size_t i = 0; i < std::min(most, report.points.size()); ++i) {
    const CorrelatedPoint& p = report.points[i];
    std::vector<std::string> row = {p.name, decimal_text(p.left_px.x(), 3), decimal_text(p.left_px.y(), 3),
                                    std::string(word_of(p.outcome))};
    if (p.match) {
      const AreaMatch& m = *p.match;
      row.push_back(decimal_text(m.position_px.x(), 3));
      row.push_back(decimal_text(m.position_px.y(), 3));
      if (const auto& c = m.covariance_px2) {
        const double x = std::sqrt((*c)(0, 0)), y = std::sqrt((*c)(1, 1));
        for (const auto& [value, decimals] : {std::pair(x, 4), std::pair(y, 4), std::pair((*c)(0, 1) / (x * y), 3)})
          row.push_back(decimal_text(value, decimals));
      } else {
        row.insert(row.end(), 3, "");
      }
      row.push_back(fmt::format("{:.6g}", m.value));
      row.push_back(m.returned_px ? decimal_text(*m.returned_px, 3) : "");
    } else {
      row.insert(row.end(), 7, "");
    }
    row.push_back(std::to_string(p.candidates));
    if (report.is_relaxed) row.push_back(p.probability ? decimal_text(*p.probability, 3) : "");
    table.rows.push_back(std::move(row));
  }
  return table;
}

std::string outcomes_text(const CorrelateReport& report) {
  std::string text;
  for (const auto& [outcome, word, help] : kAreaOutcomeWords) {
    const auto count = std::count_if(report.points.begin(), report.points.end(),
                                     [&](const CorrelatedPoint& point) { return point.outcome == outcome; });
    if (count > 0) text += fmt::format("  {:<13} {:>7}  {}\n", word, count, help);
  }
  return text;
}

std::string precision_text(const CorrelateReport& report) {
  std::vector<double> sigmas;
  for (const CorrelatedPoint& point : report.points)
    if (point.match && point.match->covariance_px2)
      sigmas.push_back(std::sqrt(point.match->covariance_px2->trace() / 2));
  if (sigmas.empty()) return "";
  return fmt::format(
      "standard deviation of a coordinate by noise alone, median: {:.3f} px; the paraboloid over whole pixels adds up "
      "to "
      "0.1 px\n",
      median(sigmas));
}

std::string unit_of(std::string_view parameter) {
  if (parameter == "x" || parameter == "y" || parameter == "along") return "px";
  return parameter == "offset" ? "grey" : "";
}

// Titles of the covariances of the parameters: the upper triangle, row by row, in the products of their units.
void add_covariance_titles(const std::vector<std::string_view>& names, TextTable& table) {
  for (std::size_t i = 0; i < names.size(); ++i)
    for (std::size_t k = i; k < names.size(); ++k)
      table.columns.push_back({fmt::format("cov_{}_{}", names[i], names[k]), ""});
}

std::vector<std::string> refined_cells(const CorrelateReport& report, const CorrelatedPoint& point) {
  const WindowMatch& m = *point.refined;
  const double x = std::sqrt(m.covariance_px2(0, 0)), y = std::sqrt(m.covariance_px2(1, 1));
  std::vector<std::string> cells;
  for (const auto& [value, decimals] :
       {std::pair(m.position_px.x(), 4), std::pair(m.position_px.y(), 4), std::pair(x, 4), std::pair(y, 4),
        std::pair(m.covariance_px2(0, 1) / std::max(x * y, 1e-12), 3), std::pair(m.correlation, 4),
        std::pair(m.noise_grey, 2), std::pair(m.redundancy, 0), std::pair(m.share_used, 3)})
    cells.push_back(decimal_text(value, decimals));
  cells.push_back(std::to_string(m.iterations));
  if (report.refine_return_px)
    cells.push_back(point.refined_returned_px ? decimal_text(*point.refined_returned_px, 4) : "");
  if (report.has_epipolar_lines) cells.push_back(point.off_line_px ? decimal_text(*point.off_line_px, 3) : "");
  for (Eigen::Index i = 0; i < m.parameters.size(); ++i) {
    cells.push_back(decimal_text(m.parameters[i], 5));
    cells.push_back(decimal_text(std::sqrt(m.covariance(i, i)), 5));
  }
  for (Eigen::Index i = 0; i < m.parameters.size(); ++i)
    for (Eigen::Index k = i; k < m.parameters.size(); ++k) cells.push_back(fmt::format("{:.4e}", m.covariance(i, k)));
  return cells;
}

std::string refinement_text(const CorrelateReport& report) {
  if (!report.refine) return "";
  std::vector<double> sigmas, noises, moves;
  std::size_t tried = 0;
  std::string outcomes;
  for (const auto& [outcome, word, help] : kWindowOutcomeWords) {
    std::size_t count = 0;
    for (const CorrelatedPoint& point : report.points)
      count += point.refined && point.refined->outcome == outcome ? 1U : 0U;
    tried += count;
    if (count > 0 && outcome != WindowOutcome::kFound)
      outcomes += fmt::format("  {:<13} {:>7}  {}\n", word, count, help);
  }
  for (const CorrelatedPoint& point : report.points)
    if (point.is_refined()) {
      const double axes = report.refine == WindowModel::kLine ? 1 : 2;
      sigmas.push_back(std::sqrt(point.refined->covariance_px2.trace() / axes));
      noises.push_back(point.refined->noise_grey);
      moves.push_back((point.refined->position_px - point.match->position_px).norm());
    }
  std::string text = fmt::format("refined by least squares matching ({}, light {}{}): {} of {}\n",
                                 word_of(*report.refine), word_of(report.window.light),
                                 report.window.robust ? ", robust" : "", sigmas.size(), counted_text(tried, "point"));
  if (!sigmas.empty())
    text += fmt::format(
        "standard deviation of a coordinate, median: {:.3f} px; noise of a pixel, median: {:.1f} grey values; moved by "
        "{:.2f} px (median)\n",
        median(sigmas), median(noises), median(moves));
  return text + outcomes;
}

// Shades from the worst value (black) to the best (white).
void draw_map(Svg& svg, const CorrelationSurface& surface, float low, float high) {
  const double side = kMapSide / std::max(surface.values.width, surface.values.height);
  for (int y = 0; y < surface.values.height; ++y)
    for (int x = 0; x < surface.values.width; ++x) {
      float share = (surface.values.at(x, y) - low) / std::max(high - low, 1e-12F);
      if (!is_larger_better(surface.method)) share = 1 - share;
      const int grey = std::clamp(int(255 * share + 0.5F), 0, 255);
      svg.rectangle(12 + x * side, 12 + y * side, side + 0.3, side + 0.3, "",
                    fmt::format("#{0:02x}{0:02x}{0:02x}", grey));
    }
}

void draw_profile(Svg& svg, const std::vector<Vector2d>& values, double top, std::string_view title,
                  std::string_view value_title) {
  double low = values.front().y(), high = low;
  for (const Vector2d& value : values) low = std::min(low, value.y()), high = std::max(high, value.y());
  if (!(high > low)) high = low + 1;
  const double left = kMapSide + 90;
  const Axis x{values.front().x(), values.back().x(), left, left + kChartWidth - 80},
      y{low, high, top + kChartHeight - 46, top + 12};
  if (!(x.high > x.low)) return;
  draw_axes(svg, x, y, title, value_title);
  std::vector<Vector2d> curve;
  for (const Vector2d& value : values) curve.emplace_back(x(value.x()), y(value.y()));
  svg.path(curve, "curve");
}

}  // namespace

TextTable correlated_table(const CorrelateReport& report) {
  TextTable table = rows_of(report, report.points.size());
  table.remarks = {fmt::format("points of {} in {} by {}; middle of the upper left pixel 0.5, 0.5", report.left,
                               report.right, word_of(report.options.method))};
  return table;
}

TextTable refined_windows_table(const CorrelateReport& report) {
  TextTable table;
  table.columns = {{"point", ""},          {"x_left", "px"},    {"y_left", "px"},  {"outcome", ""},
                   {"x_right", "px"},      {"y_right", "px"},   {"sigma_x", "px"}, {"sigma_y", "px"},
                   {"correlation_xy", ""}, {"correlation", ""}, {"noise", "grey"}, {"redundancy", ""},
                   {"share_used", ""},     {"iterations", ""}};
  if (report.refine_return_px) table.columns.push_back({"returned", "px"});
  if (report.has_epipolar_lines) table.columns.push_back({"off_line", "px"});
  const WindowModel model = report.refine.value_or(WindowModel::kTranslation);
  const auto names = window_parameter_names(model, report.window.light);
  for (const std::string_view name : names) {
    table.columns.push_back({"parameter_" + std::string(name), unit_of(name)});
    table.columns.push_back({"sigma_parameter_" + std::string(name), unit_of(name)});
  }
  add_covariance_titles(names, table);
  for (const CorrelatedPoint& p : report.points) {
    if (!p.refined) continue;
    std::vector<std::string> row = {p.name, decimal_text(p.left_px.x(), 3), decimal_text(p.left_px.y(), 3),
                                    std::string(word_of(p.refined->outcome))};
    if (p.is_refined()) {
      const auto cells = refined_cells(report, p);
      row.insert(row.end(), cells.begin(), cells.end());
    } else {
      row.resize(table.columns.size());
    }
    table.rows.push_back(std::move(row));
  }
  table.remarks = {fmt::format("points of {} in {} by least squares matching: {}, light {}, window {} px", report.left,
                               report.right, word_of(model), word_of(report.window.light), report.window.window_px)};
  return table;
}

std::string correlate_text(const CorrelateReport& report) {
  std::string text = fmt::format(
      "{} of {} in {} by {}{}; mean parallax {:.1f} {:.1f} px ({})\n", counted_text(report.points.size(), "point"),
      report.left, report.right, word_of(report.options.method), report.is_relaxed ? ", decided by neighbours" : "",
      report.parallax_px.x(), report.parallax_px.y(), report.is_parallax_found ? "found" : "given");
  text +=
      outcomes_text(report) + precision_text(report) + refinement_text(report) + indented_rows(rows_of(report, kShown));
  if (report.points.size() > kShown) text += fmt::format("  ... {} more\n", report.points.size() - kShown);
  return text;
}

std::string correlation_svg(const CorrelationSurface& surface, const std::string& point) {
  const auto& data = surface.values.data;
  const auto best = is_larger_better(surface.method) ? std::max_element(data.begin(), data.end())
                                                     : std::min_element(data.begin(), data.end());
  const int index = int(best - data.begin()), column = index % surface.values.width, row = index / surface.values.width;
  const double height = 2 * kChartHeight + 10;
  Svg svg(kMapSide + kChartWidth + 40, height, "similarity of point " + point);
  draw_map(svg, surface, *std::min_element(data.begin(), data.end()), *std::max_element(data.begin(), data.end()));
  const double side = kMapSide / std::max(surface.values.width, surface.values.height);
  svg.circle({12 + (column + 0.5) * side, 12 + (row + 0.5) * side}, std::max(4.0, side), "mark");
  std::vector<Vector2d> along, across;
  for (int x = 0; x < surface.values.width; ++x) along.emplace_back(surface.left + x + 0.5, surface.values.at(x, row));
  for (int y = 0; y < surface.values.height; ++y)
    across.emplace_back(surface.top + y + 0.5, surface.values.at(column, y));
  const std::string_view name = word_of(surface.method);
  draw_profile(svg, along, 0, "column [px]", name);
  draw_profile(svg, across, kChartHeight, "row [px]", name);
  std::string text = svg.finish();
  const std::string style =
      "<style>.curve{fill:none;stroke:#1f5fa8;stroke-width:1.6}.mark{fill:none;stroke:#c2410c;stroke-width:2}"
      ".grid{stroke:#d9dee5;stroke-width:1}.frame{fill:none;stroke:#5b6778;stroke-width:1}"
      ".label{font:11px sans-serif;fill:#17212f}</style>";
  const std::size_t at = text.find('>');
  text.insert(at + 1, style);
  if (text.find("xmlns=") == std::string::npos) text.insert(4, " xmlns=\"http://www.w3.org/2000/svg\"");
  return text;
}

}  // namespace collinea
