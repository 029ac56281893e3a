// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/interest_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "collinea/report/internal/svg.h"

namespace collinea {
namespace {

using Eigen::Vector2d;

constexpr std::size_t kShown = 10;  // points on the screen
constexpr std::array<ImageChange, 3> kChanges = {ImageChange::kRotation, ImageChange::kScale, ImageChange::kNoise};
constexpr std::array<const char*, 9> kColours = {"#1f5fa8", "#c2410c", "#0b7a75", "#7b3fa0", "#b7791f",
                                                 "#17212f", "#d6336c", "#5b8c2a", "#5b6778"};
constexpr double kChartWidth = 330, kChartHeight = 300, kLegendHeight = 30;

struct Sigmas {
  double x, y, correlation;
};

Sigmas sigmas_of(const Eigen::Matrix2d& covariance) {
  const double x = std::sqrt(covariance(0, 0)), y = std::sqrt(covariance(1, 1));
  return {x, y, x > 0 && y > 0 ? covariance(0, 1) / (x * y) : 0};
}

bool has_covariances(const InterestReport& report) {
  return std::ranges::any_of(report.found.points, [](const InterestPoint& p) { return p.covariance_px2.has_value(); });
}

TextTable points_table(const InterestReport& report, std::size_t most) {
  const bool with_covariance = has_covariances(report);
  TextTable table;
  table.columns = {{"point", ""}, {"x", "px"}, {"y", "px"}, {"strength", ""}, {"scale", "px"}};
  if (with_covariance)
    for (const TableColumn& column : std::array<TableColumn, 5>{
             {{"sigma_x", "px"}, {"sigma_y", "px"}, {"correlation", ""}, {"roundness", ""}, {"kind", ""}}})
      table.columns.push_back(column);
  for (std::size_t i = 0; i < std::min(most, report.found.points.size()); ++i) {
    const InterestPoint& p = report.found.points[i];
    std::vector<std::string> row = {std::to_string(i + 1), fmt::format("{:.3f}", p.position_px.x()),
                                    fmt::format("{:.3f}", p.position_px.y()), fmt::format("{:.6g}", p.strength),
                                    fmt::format("{:.2f}", p.scale_px)};
    if (with_covariance && !p.covariance_px2) row.insert(row.end(), 5, "-");
    if (with_covariance && p.covariance_px2) {
      const Sigmas s = sigmas_of(*p.covariance_px2);
      const bool is_adjusted = p.roundness > 0;  // by least squares
      for (std::string word :
           {fmt::format("{:.4f}", s.x), fmt::format("{:.4f}", s.y), fmt::format("{:.3f}", s.correlation),
            is_adjusted ? fmt::format("{:.3f}", p.roundness) : std::string("-"),
            std::string(!is_adjusted  ? "-"
                        : p.is_circle ? "circle"
                                      : "corner")})
        row.push_back(std::move(word));
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

double median_of(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

std::string rejected_text(const InterestPoints& found) {
  std::string text;
  if (found.isolated > 0) text += fmt::format(", {} made by a single pixel", found.isolated);
  if (found.on_edges > 0) text += fmt::format(", {} along edges", found.on_edges);
  if (found.not_located > 0) text += fmt::format(", {} not located by least squares", found.not_located);
  return text.empty() ? text : "rejected: " + text.substr(2) + "\n";
}

std::string precision_text(const InterestReport& report) {
  std::vector<double> sigmas;
  std::size_t circles = 0, adjusted = 0;
  for (const InterestPoint& p : report.found.points) {
    if (p.covariance_px2) sigmas.push_back(std::sqrt(p.covariance_px2->trace() / 2));
    circles += p.is_circle;
    adjusted += p.roundness > 0;
  }
  std::string text = fmt::format(
      "noise of a pixel {:.2f} grey levels{}; standard deviation of a coordinate by it, median of the points: {:.3f} "
      "px\n",
      report.found.noise_grey, report.options.noise_grey ? "" : " (found in the image)", median_of(sigmas));
  if (adjusted > 0)
    text += fmt::format("{} corners and junctions, {} centres of circles\n", adjusted - circles, circles);
  return text;
}

// The rows of an operator and a change, in their order.
std::vector<RepeatabilityRow> rows_of(const InterestReport& report, InterestOperator method, ImageChange change) {
  std::vector<RepeatabilityRow> rows;
  for (const RepeatabilityRow& row : report.repeatability)
    if (row.method == method && row.change == change) rows.push_back(row);
  return rows;
}

std::vector<InterestOperator> operators_of(const InterestReport& report) {
  std::vector<InterestOperator> operators;
  for (const RepeatabilityRow& row : report.repeatability)
    if (std::ranges::find(operators, row.method) == operators.end()) operators.push_back(row.method);
  return operators;
}

std::string title_of(ImageChange change) {
  switch (change) {
    case ImageChange::kRotation:
      return "rotation [deg]";
    case ImageChange::kScale:
      return "scale";
    case ImageChange::kNoise:
      return "noise [grey levels]";
  }
  return {};
}

void draw_chart(Svg& svg, const InterestReport& report, ImageChange change, double left) {
  double low = 1e300, high = -1e300;
  for (const RepeatabilityRow& row : report.repeatability)
    if (row.change == change) {
      low = std::min(low, row.amount);
      high = std::max(high, row.amount);
    }
  if (!(high > low)) return;
  const Axis x{low, high, left + 62, left + kChartWidth - 12}, y{0, 100, kChartHeight - 46, 14};
  draw_axes(svg, x, y, title_of(change), "repeatability [%]");
  const std::vector<InterestOperator> operators = operators_of(report);
  for (std::size_t k = 0; k < operators.size(); ++k) {
    std::vector<Vector2d> curve;
    for (const RepeatabilityRow& row : rows_of(report, operators[k], change))
      curve.emplace_back(x(row.amount), y(100 * row.result.rate()));
    svg.path(curve, fmt::format("operator{}", k));
    for (const Vector2d& p : curve) svg.circle(p, 2.4, fmt::format("mark{}", k));
  }
}

}  // namespace

TextTable points_table(const InterestReport& report) {
  TextTable table = points_table(report, report.found.points.size());
  table.remarks = {fmt::format("points of {}: operator {}, sigma {} px; middle of the upper left pixel 0.5, 0.5",
                               report.image, word_of(report.options.method), report.options.sigma_px)};
  if (has_covariances(report))
    table.remarks.push_back(fmt::format("sigmas by noise of {:.2f} grey levels a pixel", report.found.noise_grey));
  return table;
}

TextTable repeatability_table(const InterestReport& report) {
  TextTable table;
  table.remarks = {fmt::format("points of {} found again in the changed image within {} px, one to one", report.image,
                               report.tolerance_px),
                   "amount: degrees, size after beside before, grey levels. repeatability: pairs beside the smaller "
                   "number of points; "
                   "of_second: beside that of the changed image"};
  for (const char* name : {"operator", "change", "amount", "first", "second", "pairs", "repeatability", "of_second"})
    table.columns.push_back({name, ""});
  table.columns.push_back({"rms", "px"});
  for (const RepeatabilityRow& row : report.repeatability)
    table.rows.push_back({std::string(word_of(row.method)), std::string(word_of(row.change)),
                          fmt::format("{:g}", row.amount), std::to_string(row.result.first),
                          std::to_string(row.result.second), std::to_string(row.result.repeated),
                          fmt::format("{:.3f}", row.result.rate()), fmt::format("{:.3f}", row.result.rate_of_second()),
                          fmt::format("{:.3f}", row.result.rms_px)});
  return table;
}

std::string repeatability_svg(const InterestReport& report) {
  Svg svg(kChartWidth * kChanges.size(), kChartHeight + kLegendHeight, "Repeatability of interest operators");
  for (std::size_t i = 0; i < kChanges.size(); ++i)
    draw_chart(svg, report, kChanges[i], kChartWidth * static_cast<double>(i));
  const std::vector<InterestOperator> operators = operators_of(report);
  std::string looks =
      "text{font:12px sans-serif;fill:#17212f}.grid{stroke:#e4e8ee;stroke-width:1}.frame{fill:none;stroke:#5b6778}\n";
  for (std::size_t k = 0; k < operators.size(); ++k) {
    const char* colour = kColours[k % kColours.size()];
    looks += fmt::format(".operator{0}{{fill:none;stroke:{1};stroke-width:1.6}}.mark{0}{{fill:{1}}}\n", k, colour);
    const double x = 62 + 100 * static_cast<double>(k), y = kChartHeight + 14;
    svg.line({x, y - 4}, {x + 18, y - 4}, fmt::format("operator{}", k));
    svg.text({x + 23, y}, word_of(operators[k]));
  }
  std::string text = svg.finish();
  text.insert(text.find('\n') + 1,
              "<style>" + looks + "</style>\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n");
  text.insert(text.find("<svg") + 4, " xmlns=\"http://www.w3.org/2000/svg\"");
  return text;
}

std::string interest_text(const InterestReport& report) {
  const InterestPoints& found = report.found;
  std::string text = fmt::format("{}: {} x {} px, operator {}: {} points", report.image, report.width, report.height,
                                 word_of(report.options.method), found.points.size());
  if (report.options.method != InterestOperator::kSift)
    text += fmt::format(" of {} maxima above {:.4g}", found.maxima, found.threshold);
  text += "\n" + rejected_text(found);
  if (found.points.empty())
    return text + "nothing stands out: a lower threshold, or a sigma nearer to the size of what the image shows\n";
  if (has_covariances(report)) text += precision_text(report);
  text +=
      fmt::format("\nthe first {}:\n", std::min(kShown, found.points.size())) + text_of(points_table(report, kShown));
  if (!report.repeatability.empty()) {
    TextTable table = repeatability_table(report);
    text += "\n";
    for (const std::string& remark : table.remarks) text += remark + "\n";
    table.remarks.clear();
    text += text_of(table);
  }
  return text;
}

}  // namespace collinea
