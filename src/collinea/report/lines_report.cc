// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/lines_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "collinea/math/median.h"
#include "collinea/report/single_step.h"

namespace collinea {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;
constexpr std::size_t kShown = 20;  // rows on the screen

// The largest standard deviation across a line at a position along it.
double sigma_at(const SpaceLine& line, double along_m) {
  const Eigen::Matrix2d c = line.covariance_at(along_m);
  const double half = (c(0, 0) + c(1, 1)) / 2;
  return std::sqrt(half + std::sqrt(std::max(half * half - c.determinant(), 0.0)));
}

double direction_sigma(const SpaceLine& line) {
  SpaceLine tilts = line;
  tilts.covariance.topLeftCorner<2, 2>() = line.covariance.bottomRightCorner<2, 2>();
  return sigma_at(tilts, 0);
}

double disparity_sigma(const PairLine& line, double row) {
  const auto left = crossing(line.left, row), right = crossing(*line.right, row);
  return left && right ? std::hypot(left->sigma_px, right->sigma_px) : 0;
}

void add_match(std::vector<std::string>& row, const PairLine& line) {
  if (!line.decision.match) {
    row.insert(row.end(), 9, "");
    return;
  }
  const LineCandidate& m = *line.decision.match;
  row.push_back(std::to_string(m.right + 1));
  for (const auto& [value, decimals] :
       {std::pair(m.first_row, 2), std::pair(m.last_row, 2), std::pair(m.first_disparity, 3),
        std::pair(disparity_sigma(line, m.first_row), 3), std::pair(m.last_disparity, 3),
        std::pair(disparity_sigma(line, m.last_row), 3), std::pair(m.rotation_rad * kDegrees, 2),
        std::pair(m.similarity, 3)})
    row.push_back(decimal_text(value, decimals));
}

void add_space(std::vector<std::string>& row, const PairLine& line) {
  if (!line.space) {
    row.insert(row.end(), 11, "");
    return;
  }
  const MatchedSpaceLine& s = *line.space;
  for (const double along : {s.from_m, s.to_m}) {
    const Eigen::Vector3d at = s.line.at(along);
    for (int k = 0; k < 3; ++k) row.push_back(decimal_text(at[k], 4));
    row.push_back(decimal_text(sigma_at(s.line, along), 4));
  }
  row.push_back(decimal_text(std::abs(s.to_m - s.from_m), 4));
  row.push_back(decimal_text(direction_sigma(s.line) * kDegrees, 4));
  row.push_back(decimal_text(s.line.angle_rad * kDegrees, 3));
}

TextTable rows_of(const LinesReport& report) {
  TextTable table;
  table.columns = {{"line", ""},
                   {"outcome", ""},
                   {"candidates", ""},
                   {"x_from", "px"},
                   {"y_from", "px"},
                   {"x_to", "px"},
                   {"y_to", "px"},
                   {"right_line", ""},
                   {"first_row", "px"},
                   {"last_row", "px"},
                   {"first_disparity", "px"},
                   {"sigma_first", "px"},
                   {"last_disparity", "px"},
                   {"sigma_last", "px"},
                   {"rotation", "deg"},
                   {"similarity", ""},
                   {"X_first", "m"},
                   {"Y_first", "m"},
                   {"Z_first", "m"},
                   {"sigma_across_first", "m"},
                   {"X_last", "m"},
                   {"Y_last", "m"},
                   {"Z_last", "m"},
                   {"sigma_across_last", "m"},
                   {"length", "m"},
                   {"sigma_direction", "deg"},
                   {"angle_of_planes", "deg"}};
  for (std::size_t i = 0; i < report.lines.size(); ++i) {
    const PairLine& line = report.lines[i];
    std::vector<std::string> row = {std::to_string(i + 1), std::string(word_of(line.decision.outcome)),
                                    std::to_string(line.decision.candidates)};
    for (const Eigen::Vector2d& end : {line.left.from, line.left.to})
      for (int k = 0; k < 2; ++k) row.push_back(decimal_text(end[k], 2));
    add_match(row, line);
    add_space(row, line);
    table.rows.push_back(std::move(row));
  }
  return table;
}

// The first matched lines, with what fits on a screen.
TextTable shown_rows(const LinesReport& report) {
  const TextTable all = rows_of(report);
  std::vector<std::size_t> columns;
  TextTable table;
  for (const char* name : {"line", "right_line", "outcome", "first_row", "last_row", "first_disparity", "sigma_first",
                           "last_disparity", "sigma_last", "similarity", "length", "sigma_across_first"}) {
    columns.push_back(*all.find(name));
    table.columns.push_back(all.columns[columns.back()]);
  }
  for (std::size_t i = 0; i < all.rows.size() && table.rows.size() < kShown; ++i) {
    if (!report.lines[i].decision.match) continue;
    auto& row = table.rows.emplace_back();
    for (const std::size_t column : columns) row.push_back(all.rows[i][column]);
  }
  return table;
}

std::string frame_remark(const LinesReport& report) {
  return report.frame == PairFrame::kLeftCamera ? "coordinates in space: x right, y down, z forward of the left camera"
                                                : "coordinates in space: the frame of the orientation";
}

std::vector<TableColumn> point_columns(const char* name) {
  return {{name, ""},     {"x_left", "px"},    {"y_left", "px"}, {"x_right", "px"}, {"sigma_disparity", "px"},
          {"depth", "m"}, {"sigma_depth", "m"}};
}

// Where an edge point lies in both images, and how far away it is where the cameras are known.
void add_point(std::vector<std::string>& row, const EdgePointMatch& p, const LinesReport& report) {
  for (const double value : {p.left_px.x(), p.left_px.y(), p.right_px.x(), p.sigma_px})
    row.push_back(decimal_text(value, 3));
  if (!report.cameras) {
    row.insert(row.end(), 2, "");
    return;
  }
  const auto& [left, right, pose, base_m, points] = *report.cameras;
  const double parallax = p.left_px.x() - p.right_px.x() - left.params[Camera::kCx] + right.params[Camera::kCx];
  const double depth = left.focal_px() * base_m / parallax;
  row.push_back(decimal_text(depth, 4));
  row.push_back(decimal_text(depth / parallax * p.sigma_px, 4));
}

std::string curves_text(const LinesReport& report) {
  if (!report.curves) return "";
  std::vector<double> sigmas;
  for (const PairCurves::Curve& curve : report.curves->curves)
    for (const EdgePointMatch& p : curve.points) sigmas.push_back(p.sigma_px);
  std::string text = fmt::format("edges of any shape: {} of {} and {}, undecided candidates: {}\n",
                                 counted_text(report.curves->curves.size(), "matched piece"), report.curves->left,
                                 report.curves->right, report.curves->undecided);
  if (!sigmas.empty()) {
    const std::size_t count = sigmas.size();
    text += fmt::format("  {}, standard deviation of a disparity, median: {:.3f} px\n", counted_text(count, "point"),
                        median(sigmas));
  }
  return text;
}

std::string precision_text(const LinesReport& report) {
  std::vector<double> across, directions, disparities;
  for (const PairLine& line : report.lines) {
    if (line.decision.match) disparities.push_back(disparity_sigma(line, line.decision.match->middle_row()));
    if (!line.space) continue;
    across.push_back(sigma_at(line.space->line, (line.space->from_m + line.space->to_m) / 2));
    directions.push_back(direction_sigma(line.space->line) * kDegrees);
  }
  std::string text;
  if (!disparities.empty())
    text += fmt::format("standard deviation of a disparity in the middle of a line, median: {:.3f} px\n",
                        median(disparities));
  if (!across.empty())
    text += fmt::format("across a line in space: {:.4f} m, of its direction: {:.3f} degrees (medians)\n",
                        median(across), median(directions));
  return text;
}

}  // namespace

std::size_t LinesReport::matched() const {
  return std::size_t(
      std::ranges::count_if(lines, [](const PairLine& line) { return line.decision.match.has_value(); }));
}
std::size_t LinesReport::in_space() const {
  return std::size_t(std::ranges::count_if(lines, [](const PairLine& line) { return line.space.has_value(); }));
}

TextTable lines_table(const LinesReport& report) {
  TextTable table = rows_of(report);
  table.remarks = {
      fmt::format("straight edges of the epipolar images of {} and {}; middle of the upper left pixel "
                  "0.5, 0.5",
                  report.left, report.right)};
  if (report.cameras) table.remarks.push_back(frame_remark(report));
  return table;
}

TextTable edge_points_table(const LinesReport& report) {
  TextTable table;
  table.columns = point_columns("line");
  for (std::size_t i = 0; i < report.lines.size(); ++i)
    for (const EdgePointMatch& p : report.lines[i].points) {
      std::vector<std::string> row = {std::to_string(i + 1)};
      add_point(row, p, report);
      table.rows.push_back(std::move(row));
    }
  return table;
}

TextTable curve_points_table(const LinesReport& report) {
  TextTable table;
  table.columns = point_columns("curve");
  table.columns.push_back({"outcome", ""});
  if (!report.curves) return table;
  for (std::size_t i = 0; i < report.curves->curves.size(); ++i)
    for (const EdgePointMatch& p : report.curves->curves[i].points) {
      std::vector<std::string> row = {std::to_string(i + 1)};
      add_point(row, p, report);
      row.emplace_back(word_of(report.curves->curves[i].match.outcome));
      table.rows.push_back(std::move(row));
    }
  return table;
}

std::string lines_text(const LinesReport& report) {
  std::string text =
      fmt::format("{} of {}, {} of {}; disparities {} to {} px\n", counted_text(report.lines.size(), "straight edge"),
                  report.left, report.right_lines, report.right, report.low_px, report.high_px);
  for (const auto& [outcome, word, help] : kLineOutcomeWords) {
    const auto count = std::ranges::count_if(
        report.lines, [&, of = outcome](const PairLine& line) { return line.decision.outcome == of; });
    if (count > 0) text += fmt::format("  {:<13} {:>6}  {}\n", word, count, help);
  }
  text += fmt::format("matched: {}", report.matched());
  text += report.cameras ? fmt::format(", in space: {}\n", report.in_space())
                         : "; no coordinates in space: the cameras are not known\n";
  return text + precision_text(report) + curves_text(report) + indented_rows(shown_rows(report));
}

}  // namespace collinea
