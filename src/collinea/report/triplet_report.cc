// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/triplet_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "collinea/report/findings_text.h"

namespace collinea {
namespace {

// The four orientations of a pair are A, B, C, D (Mussio 3.3.4, table of combinations).
std::string solution_name(int pair, int solution) { return fmt::format("{}{}", pair, "ABCD"[solution]); }

std::string unit_of(const TripletReport& report) { return report.base_is_given ? "m" : ""; }

std::string pairs_text(const TripletReport& report) {
  std::string text;
  for (std::size_t p = 0; p < 2; ++p) {
    const TripletReport::Pair& pair = report.pairs[p];
    text += fmt::format("pair {} ({}, {}): {}, {} rejected, sigma0 {:.3g}; in front of both images:", p + 1,
                        report.images[p].name, report.images[p + 1].name, counted_text(pair.points, "point"),
                        pair.rejected.size(), pair.sigma0);
    for (int k = 0; k < 4; ++k)
      text += fmt::format(" {} {}", solution_name(static_cast<int>(p) + 1, k), pair.in_front[std::size_t(k)]);
    text += "\n";
    if (!pair.rejected.empty()) text += fmt::format("  rejected points: {}\n", fmt::join(pair.rejected, " "));
  }
  return text;
}

TextTable combinations_table(const TripletReport& report) {
  TextTable table;
  table.columns = {{"first", ""},    {"second", ""},     {"base_ratio", ""}, {"scatter", ""},
                   {"in_front", ""}, {"acceptable", ""}, {"chosen", ""}};
  for (std::size_t k = 0; k < report.joined.combinations.size(); ++k) {
    const ThreeImageCombination& one = report.joined.combinations[k];
    table.rows.push_back({solution_name(1, one.of_first), solution_name(2, one.of_second),
                          decimal_text(one.base_ratio, 6), fmt::format("{:.2e}", one.scatter),
                          std::to_string(one.in_front), one.is_joined ? "yes" : "no",
                          static_cast<int>(k) == report.joined.chosen ? "yes" : "no"});
  }
  return table;
}

TextTable model_table(const TripletReport& report) {
  const std::string unit = unit_of(report);
  TextTable table;
  table.remarks = {
      fmt::format("model coordinates: axes of image {} (x right, y up, z backwards), base {} to {}: {:g} {}",
                  report.images[0].name, report.images[0].name, report.images[1].name, report.base, unit)};
  table.columns = {{"point", ""}};
  for (const char* name : {"U", "V", "W", "sigma_U", "sigma_V", "sigma_W"}) table.columns.push_back({name, unit});
  for (const char* name : {"correlation_UV", "correlation_UW", "correlation_VW", "rays"})
    table.columns.push_back({name, ""});
  for (const TripletReport::Point& point : report.points) {
    const Eigen::Matrix3d& c = point.covariance;
    const Eigen::Vector3d s = c.diagonal().cwiseMax(1e-300).cwiseSqrt();
    std::vector<std::string> row{point.name};
    for (const double value : point.position) row.push_back(fmt::format("{:.9g}", value));
    for (const double value : s) row.push_back(fmt::format("{:.3g}", value));
    for (const auto& [i, j] : {std::pair(0, 1), {0, 2}, {1, 2}})
      row.push_back(decimal_text(c(i, j) / (s[i] * s[j]), 4));
    row.push_back(std::to_string(point.rays));
    table.rows.push_back(std::move(row));
  }
  return table;
}

TextTable residual_table(const TripletReport& report) {
  const std::string unit(report.frame.unit());
  TextTable table;
  table.columns = {{"image", ""}, {"point", ""}, {"dx", unit}, {"dy", unit}, {"w_x", ""},
                   {"w_y", ""},   {"r_x", ""},   {"r_y", ""},  {"used", ""}};
  const int decimals = report.frame.y_up ? 5 : 3;
  for (const TripletReport::Mark& mark : report.marks) {
    std::vector<std::string> row{mark.image, mark.point};
    for (const double value : mark.test.misfit) row.push_back(decimal_text(value, decimals));
    for (const Eigen::Vector2d& values : {mark.test.w, mark.test.redundancy})
      for (const double value : values) row.push_back(mark.is_rejected ? "-" : decimal_text(value, 2));
    row.push_back(mark.is_rejected ? "no" : "yes");
    table.rows.push_back(std::move(row));
  }
  return table;
}

std::string choice_text(const TripletReport& report) {
  const auto& all = report.joined.combinations;
  const auto acceptable = std::count_if(all.begin(), all.end(), [](const auto& one) { return one.is_joined; });
  const ThreeImageCombination& chosen = all[static_cast<std::size_t>(report.joined.chosen)];
  return fmt::format(
      "{} of 16 combinations are acceptable: all points agree on one ratio of the bases. Chosen is {} with {}, which "
      "has {} of {} points in front of all images\n",
      acceptable, solution_name(1, chosen.of_first), solution_name(2, chosen.of_second), chosen.in_front,
      report.common);
}

std::string suspect_text(const TripletReport& report) {
  const TripletReport::Mark* worst = nullptr;
  const auto largest = [](const TripletReport::Mark& mark) { return mark.test.w.cwiseAbs().maxCoeff(); };
  std::size_t tests = 0;
  for (const TripletReport::Mark& mark : report.marks) tests += mark.is_rejected ? 0 : 2;
  for (const TripletReport::Mark& mark : report.marks)
    if (!mark.is_rejected && (!worst || largest(mark) > largest(*worst))) worst = &mark;
  if (!worst || report.variance.redundancy <= 0) return "";
  return largest_test_text(report.variance, tests, largest(*worst), worst->point, worst->image);
}

}  // namespace

std::string triplet_text(const TripletReport& report) {
  std::string text =
      fmt::format("orientation of three images by two pairs: {} common to all\n", counted_text(report.common, "point"));
  text += pairs_text(report);
  text += "combinations of their orientations (base of pair 2 over that of pair 1, median deviation of points):\n" +
          indented_rows(combinations_table(report)) + choice_text(report);
  text += fmt::format("least squares of all bundles, {} iterations:\n", report.iterations);
  text += variance_text(report.variance) + estimates_text(std::span(&report.base_ratio, 1));
  for (const TripletReport::Image& image : report.images)
    text += fmt::format("image {}:\n", image.name) + estimates_text(image.exterior);
  text += fmt::format("conditioning: smallest over largest eigenvalue {:.2e}\n", report.conditioning);
  text += "residuals, measured minus computed:\n" + indented_rows(residual_table(report));
  return text + suspect_text(report) + findings_text(report.findings);
}

std::vector<NamedTable> triplet_tables(const TripletReport& report) {
  std::vector<std::string> names;
  std::vector<std::vector<Estimate>> exterior;
  std::vector<Eigen::Matrix<double, 6, 6>> covariances;
  for (const TripletReport::Image& image : report.images) {
    names.push_back(image.name);
    exterior.push_back(image.exterior);
    covariances.push_back(image.covariance);
  }
  return {{"combinations.txt", combinations_table(report)},
          {"exterior.txt", exterior_table(names, exterior, covariances)},
          {"model.txt", model_table(report)},
          {"residuals.txt", residual_table(report)}};
}

}  // namespace collinea
