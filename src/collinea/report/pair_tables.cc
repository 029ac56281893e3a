// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>

#include "collinea/io/text.h"
#include "collinea/report/pair_report.h"

namespace collinea {
namespace {

// By sigma0 as it was estimated.
double test_of(const PairResidual& residual, const RelativeOrientation& orientation) {
  const double unit = std::sqrt(orientation.variance_factor);
  return unit > 0 ? residual.standardised / unit : 0;
}

std::vector<TableColumn> pixel_columns() {
  return {{"x_left", "px"}, {"y_left", "px"}, {"x_right", "px"}, {"y_right", "px"}};
}

void add_pixels(const MatchedPoint& point, int shrink, std::vector<std::string>& row) {
  for (const double at : {point.left_px.x(), point.left_px.y(), point.right_px.x(), point.right_px.y()})
    row.push_back(fixed(at * shrink, 3));
}

// The points of the last relative orientation, named as there.
TextTable point_table(const PairReport& report) {
  const PairOrientation& last = report.orientations.back();
  const RelativeReport& relative = *report.relative;
  TextTable table;
  table.remarks = {
      "homologous points; coordinates of the image files; sigma: of each coordinate; y-parallax left by the relative "
      "orientation, its redundancy and test; used: by the orientation"};
  table.columns = pixel_columns();
  table.columns.insert(table.columns.begin(), {"point", ""});
  table.columns.insert(
      table.columns.end(),
      {{"sigma", "px"}, {"y_parallax", "px"}, {"ncc", "1"}, {"redundancy", "1"}, {"test", "1"}, {"used", ""}});
  const double unit_px = last.shrink * std::sqrt(last.orientation.variance_factor);
  for (std::size_t i = 0; i < last.matched.size(); ++i) {
    const PairResidual& residual = last.orientation.residuals[i];
    std::vector<std::string> row{relative.names[i]};
    add_pixels(last.matched[i], last.shrink, row);
    row.insert(row.end(), {fixed(unit_px * last.matched[i].sigma_px, 4),
                           fixed(residual.y_parallax * relative.frame.camera.focal_px(), 4),
                           fixed(last.matched[i].ncc, 3), fixed(residual.redundancy, 3),
                           fixed(test_of(residual, last.orientation), 2), residual.used ? "yes" : "no"});
    table.rows.push_back(std::move(row));
  }
  return table;
}

// Of all relative orientations on the way.
TextTable rejected_table(const PairReport& report) {
  TextTable table;
  table.remarks = {
      "points rejected by the relative orientations in turn; coordinates of the image files; what is left of their "
      "y-parallax, and its test"};
  table.columns = pixel_columns();
  table.columns.insert(table.columns.begin(), {{"orientation", ""}, {"by", ""}});
  table.columns.insert(table.columns.end(), {{"y_parallax", "px"}, {"ncc", "1"}, {"test", "1"}});
  for (std::size_t k = 0; k < report.orientations.size(); ++k) {
    const PairOrientation& of = report.orientations[k];
    for (const int i : of.orientation.rejected) {
      const auto at = static_cast<std::size_t>(i);
      const PairResidual& residual = of.orientation.residuals[at];
      std::vector<std::string> row{std::to_string(k + 1), of.by};
      add_pixels(of.matched[at], of.shrink, row);
      row.insert(row.end(), {fixed(residual.y_parallax * report.relative->frame.camera.focal_px(), 4),
                             fixed(of.matched[at].ncc, 3), fixed(test_of(residual, of.orientation), 2)});
      table.rows.push_back(std::move(row));
    }
  }
  return table;
}

}  // namespace

std::vector<NamedTable> pair_tables(const PairReport& report) {
  const RelativeReport& relative = *report.relative;
  std::vector<NamedTable> tables{{"points.txt", point_table(report)},
                                 {"rejected.txt", rejected_table(report)},
                                 {"relative_parameters.txt", relative_parameter_table(relative)},
                                 {"relative_correlations.txt", relative_correlation_table(relative)},
                                 {"relative_residuals.txt", relative_residual_table(relative)},
                                 {"model.txt", relative_model_table(relative)}};
  const std::vector<std::string> images{report.exterior[0].image, report.exterior[1].image};
  const std::vector<std::vector<Estimate>> elements{report.exterior[0].elements, report.exterior[1].elements};
  const std::array covariances{report.exterior[0].covariance, report.exterior[1].covariance};
  tables.push_back({"exterior.txt", exterior_table(images, elements, covariances)});
  tables.back().table.remarks = {
      "correlations are those of the elements of one image; what both have in common is not stated"};
  if (report.control)
    for (NamedTable& table : absolute_tables(*report.control))
      tables.push_back({"absolute_" + table.name, std::move(table.table)});
  return tables;
}

}  // namespace collinea
