// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/collinearity_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>

#include "collinea/io/text.h"

namespace collinea {
namespace {

constexpr double kDegreesOfRadian = 180 / std::numbers::pi;
constexpr double kMostCoefficient_m = 10000;  // above it a constant K is not physical

TextTable image_points_table(const CollinearityReport& report) {
  TextTable table;
  table.columns = {{"image", ""},
                   {"point", ""},
                   {"x", report.unit},
                   {"y", report.unit},
                   {"sigma_x", report.unit},
                   {"sigma_y", report.unit},
                   {"distance", "m"},
                   {"N", "m"}};
  if (report.refraction)
    for (const char* name : {"x_refracted", "y_refracted", "dx", "dy", "sigma_dx", "sigma_dy"})
      table.columns.push_back({name, report.unit});
  for (const CollinearityReport::Row& row : report.rows) {
    std::vector<std::string> words{row.image, row.point};
    for (const Eigen::Vector2d& values : {row.xy, row.sigma})
      for (const double value : values) words.push_back(decimal_text(value, 6));
    words.push_back(decimal_text(row.distance_m, 3));
    words.push_back(decimal_text(row.undulation_m, 3));
    if (report.refraction)
      for (const Eigen::Vector2d& values :
           {Eigen::Vector2d(row.xy + row.refraction.shift), row.refraction.shift, row.refraction.sigma})
        for (const double value : values) words.push_back(decimal_text(value, 6));
    table.rows.push_back(std::move(words));
  }
  return table;
}

TextTable derivatives_table(const CollinearityReport& report) {
  TextTable table;
  table.remarks = {fmt::format(
      "derivatives of x and y [{}] by latitude, longitude and angles [rad], by h [m]; 0: of the centre", report.unit)};
  table.columns = {{"image", ""}, {"point", ""}, {"of", ""}};
  for (const char* name : {"latitude0", "longitude0", "h0", "omega", "phi", "kappa", "latitude", "longitude", "h"})
    table.columns.push_back({name, ""});
  for (const CollinearityReport::Row& row : report.rows)
    for (int k = 0; k < 2; ++k) {
      std::vector<std::string> words{row.image, row.point, k ? "y" : "x"};
      for (int column = 0; column < 9; ++column) words.push_back(fmt::format("{:.9g}", row.by(k, column)));
      table.rows.push_back(std::move(words));
    }
  return table;
}

std::string model_text(const RefractionModel& model) {
  return model.by_atmosphere ? "the standard atmosphere (Saastamoinen)"
                             : fmt::format("the coefficient of refraction K = {:g}", model.coefficient);
}

TextTable refraction_table(const RefractionReport& report) {
  TextTable table;
  table.columns = {{"point", ""}, {"angle", "deg"}, {"height", "m"}};
  for (const char* by : {"K", "air"})
    for (const char* name : {"dx_", "dy_", "sigma_x_", "sigma_y_"})
      table.columns.push_back({std::string(name) + by, "um"});
  for (const char* name : {"x_corrected", "y_corrected", "sigma_x", "sigma_y"})
    table.columns.push_back({name, report.unit});
  const double in_um = report.unit == "mm" ? 1e3 : 1;
  if (report.unit != "mm")
    for (TableColumn& column : table.columns)
      if (column.unit == "um") column.unit = report.unit;
  for (const RefractionReport::Row& row : report.rows) {
    std::vector<std::string> words{row.point, decimal_text(kDegreesOfRadian * row.by_atmosphere.angle_rad, 3),
                                   decimal_text(row.heights.camera_m - row.heights.ground_m, 2)};
    for (const ImageRefraction* one : {&row.by_coefficient, &row.by_atmosphere})
      for (const Eigen::Vector2d& values : {one->shift, one->sigma})
        for (const double value : values) words.push_back(decimal_text(in_um * value, 4));
    for (const Eigen::Vector2d& values : {row.corrected, row.sigma_corrected})
      for (const double value : values) words.push_back(decimal_text(value, 6));
    table.rows.push_back(std::move(words));
  }
  return table;
}

}  // namespace

std::string collinearity_text(const CollinearityReport& report) {
  std::string text = fmt::format("collinearity in geodetic coordinates (WGS84): {}\n",
                                 counted_text(report.rows.size(), "image point"));
  if (report.refraction) text += "refraction by " + model_text(*report.refraction) + "\n";
  text += indented_rows(image_points_table(report));
  for (const auto& [image, point] : report.behind) text += fmt::format("point {} lies behind image {}\n", point, image);
  return text;
}

std::vector<NamedTable> collinearity_tables(const CollinearityReport& report) {
  return {{"image_points.txt", image_points_table(report)}, {"derivatives.txt", derivatives_table(report)}};
}

std::string refraction_text(const RefractionReport& report) {
  std::string text = fmt::format("refraction of {}, by the coefficient K = {:g} and by the standard atmosphere\n",
                                 counted_text(report.rows.size(), "image point"), report.model.coefficient);
  text += indented_rows(refraction_table(report));
  text += "corrected by " + model_text(report.model) + ": seen less shift\n";
  const bool is_high = std::any_of(report.rows.begin(), report.rows.end(), [](const RefractionReport::Row& row) {
    return row.heights.camera_m - row.heights.ground_m > kMostCoefficient_m;
  });
  if (is_high && !report.model.by_atmosphere)
    text += "weak: a constant K is too large above 10 km, because air thins out. Use the standard atmosphere\n";
  return text;
}

std::vector<NamedTable> refraction_tables(const RefractionReport& report) {
  return {{"refraction.txt", refraction_table(report)}};
}

}  // namespace collinea
