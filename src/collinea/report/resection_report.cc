// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/resection_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "collinea/io/text.h"
#include "collinea/report/findings_text.h"

namespace collinea {
namespace {

TextTable marks_table(const ResectionReport& report) {
  TextTable table;
  const bool is_one = report.is_station();  // a direction has one coordinate
  table.columns = {{"image", ""}, {"point", ""}};
  const std::string unit = report.unit == "mgon" ? "mgon" : report.unit;
  table.columns.push_back({is_one ? "d_direction" : "dx", unit});
  if (!is_one) table.columns.push_back({"dy", unit});
  for (const char* name : {"w", "r"}) {
    table.columns.push_back({is_one ? std::string(name) : fmt::format("{}_x", name), ""});
    if (!is_one) table.columns.push_back({fmt::format("{}_y", name), ""});
  }
  table.columns.push_back({"used", ""});
  const int decimals = report.unit == "mm" ? 5 : 3;
  for (const ResectionReport::Mark& mark : report.marks) {
    std::vector<std::string> row{mark.image, mark.point};
    for (int k = 0; k < (is_one ? 1 : 2); ++k) row.push_back(decimal_text(mark.misfit[k], decimals));
    for (const Eigen::Vector2d& values : {mark.w, mark.redundancy})
      for (int k = 0; k < (is_one ? 1 : 2); ++k) row.push_back(mark.is_rejected ? "-" : decimal_text(values[k], 2));
    row.push_back(mark.is_rejected ? "no" : "yes");
    table.rows.push_back(std::move(row));
  }
  return table;
}

// With correlations where all of them are known: without them points intersected by the table would seem far worse.
std::optional<TextTable> correlated_orientation_table(const ResectionReport& report) {
  std::vector<std::string> images;
  std::vector<std::vector<Estimate>> exterior;
  std::vector<Eigen::Matrix<double, 6, 6>> covariances;
  for (const ResectionReport::Image& image : report.images) {
    if (image.exterior.size() != 6 || image.covariance.rows() != 6) return std::nullopt;
    images.push_back(image.name);
    exterior.push_back(image.exterior);
    covariances.emplace_back(image.covariance);
  }
  return exterior_table(images, exterior, covariances);
}

TextTable orientation_table(const ResectionReport& report) {
  TextTable table;
  table.columns = {{"image", ""}};
  if (report.images.empty()) return table;
  if (std::optional<TextTable> correlated = correlated_orientation_table(report)) return *std::move(correlated);
  for (const Estimate& e : report.images[0].exterior) table.columns.push_back({e.name, e.unit});
  for (const Estimate& e : report.images[0].exterior) table.columns.push_back({"sigma_" + e.name, e.unit});
  for (const ResectionReport::Image& image : report.images) {
    if (image.exterior.size() != report.images[0].exterior.size()) continue;
    std::vector<std::string> row{image.name};
    for (const Estimate& e : image.exterior) row.push_back(decimal_text(e.value, 8));
    for (const Estimate& e : image.exterior) row.push_back(e.sigma ? decimal_text(*e.sigma, 8) : "-");
    table.rows.push_back(std::move(row));
  }
  return table;
}

TextTable points_table(const ResectionReport& report) {
  TextTable table;
  table.columns = {{"point", ""}};
  for (const char* name : {"X", "Y", "Z", "sigma_X", "sigma_Y", "sigma_Z"}) table.columns.push_back({name, "m"});
  for (const ResectionReport::Point& point : report.tie_points) {
    std::vector<std::string> row{point.name};
    for (const Eigen::Vector3d& values : {point.position, point.sigma})
      for (const double value : values) row.push_back(decimal_text(value, 5));
    table.rows.push_back(std::move(row));
  }
  return table;
}

std::string weakest_text(const PoseConditioning& conditioning) {
  constexpr std::array<const char*, 6> kMotions{"rotation about X", "rotation about Y", "rotation about Z",
                                                "X of the centre",  "Y of the centre",  "Z of the centre"};
  std::string text;
  for (int k = 0; k < 6; ++k)
    if (std::abs(conditioning.weakest[k]) > 0.3)
      text += fmt::format("{}{}", text.empty() ? "" : ", ", kMotions[static_cast<std::size_t>(k)]);
  return text;
}

std::string geometry_text(const ResectionReport::Image& image) {
  if (!image.conditioning) return "";
  return fmt::format("conditioning: smallest over largest eigenvalue {:.2e}; worst determined together: {}\n",
                     image.conditioning->ratio, weakest_text(*image.conditioning));
}

std::string row_text(const char* name, const Eigen::RowVector3d& values, int decimals) {
  return fmt::format("  {:<4}{:>18}{:>18}{:>18}\n", name, decimal_text(values[0], decimals),
                     decimal_text(values[1], decimals), decimal_text(values[2], decimals));
}

// M = K [R | t] with its centre and its optical axis (Bolognesi 2.2, 2.3.3.2).
std::string parts_text(const ResectionReport::MatrixParts& parts, const std::string& unit) {
  std::string text =
      fmt::format("the matrix taken apart, (x, y, 1) ~ K (R X + t); K in {}, t and C in m, axes of the image {}:\n",
                  unit, unit == "px" ? "x right, y down, z forward" : "x right, y up, z backwards");
  for (int row = 0; row < 3; ++row) text += row_text(row ? "" : "K", parts.calibration.row(row), 5);
  for (int row = 0; row < 3; ++row) text += row_text(row ? "" : "R", parts.rotation.row(row), 9);
  text += row_text("t", parts.translation.transpose(), 5);
  text += row_text("C", parts.centre.transpose(), 5);
  text += row_text("axis", parts.axis.transpose(), 9);
  return text + row_text("+-", parts.sigma_axis.transpose(), 9);
}

TextTable rays_table(const ResectionReport& report) {
  TextTable table;
  table.remarks = {"rays of the measured points, of unit length, from the projection centre"};
  table.columns = {{"image", ""}, {"point", ""}, {"ray_X", ""}, {"ray_Y", ""}, {"ray_Z", ""}};
  for (const ResectionReport::Mark& mark : report.marks) {
    if (!mark.ray) continue;
    std::vector<std::string> row{mark.image, mark.point};
    for (const double value : *mark.ray) row.push_back(decimal_text(value, 9));
    table.rows.push_back(std::move(row));
  }
  return table;
}

// K, R, t, centre and optical axis, element by element.
std::vector<Estimate> matrix_estimates(const ResectionReport::MatrixParts& parts, const std::string& unit) {
  std::vector<Estimate> out;
  const auto add_matrix = [&](const char* name, const Eigen::Matrix3d& values, const Eigen::Matrix3d& sigmas,
                              const std::string& of) {
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column < 3; ++column)
        out.push_back({fmt::format("{}_{}{}", name, row + 1, column + 1), row < 2 ? of : "", values(row, column),
                       sigmas(row, column)});
  };
  const auto add_vector = [&](const char* name, const Eigen::Vector3d& values, const Eigen::Vector3d& sigmas,
                              const char* of) {
    for (int k = 0; k < 3; ++k) out.push_back({fmt::format("{}_{}", name, k + 1), of, values[k], sigmas[k]});
  };
  add_matrix("K", parts.calibration, parts.sigma_calibration, unit);
  add_matrix("R", parts.rotation, parts.sigma_rotation, "");
  add_vector("t", parts.translation, parts.sigma_translation, "m");
  add_vector("C", parts.centre, parts.sigma_centre, "m");
  add_vector("axis", parts.axis, parts.sigma_axis, "");
  return out;
}

void add_image_tables(const ResectionReport::Image& image, const std::string& unit, std::vector<NamedTable>& tables) {
  if (image.joint_covariance.size()) {
    std::vector<Estimate> all = image.exterior;
    all.insert(all.end(), image.interior.begin(), image.interior.end());
    tables.push_back({"correlations.txt", correlations_table(all, image.joint_covariance)});
  } else if (image.covariance.size()) {
    tables.push_back({"correlations.txt", correlations_table(image.exterior, image.covariance)});
  }
  if (!image.interior.empty()) tables.push_back({"interior.txt", estimates_table(image.interior)});
  if (!image.elements.empty()) {
    tables.push_back({"elements.txt", estimates_table(image.elements)});
    tables.push_back({"element_correlations.txt", correlations_table(image.elements, image.element_covariance)});
  }
  if (image.parts) tables.push_back({"matrix.txt", estimates_table(matrix_estimates(*image.parts, unit))});
}

std::string image_text(const ResectionReport& report, const ResectionReport::Image& image) {
  std::string text = fmt::format("{}{}, {}:\n", report.is_station() ? "" : "image ", image.name,
                                 counted_text(image.points, report.is_station() ? "direction" : "point"));
  if (image.robust_scale > 0)
    text += fmt::format("robust standard deviation by the least median of squares: {:.3g} {}\n", image.robust_scale,
                        report.unit);
  text += estimates_text(image.exterior);
  if (!image.interior.empty()) text += "interior orientation:\n" + estimates_text(image.interior);
  if (!image.elements.empty()) text += "elements of the transformation:\n" + estimates_text(image.elements);
  if (image.parts) text += parts_text(*image.parts, report.unit);
  if (image.covariance.size()) text += correlations_text(image.exterior, image.covariance, 0.8);
  if (image.solutions.size() > 1) {
    text += fmt::format("three points have {} poses; taken is the first:\n", image.solutions.size());
    for (const auto& solution : image.solutions) {
      for (const Estimate& e : solution) text += fmt::format("  {} {}", e.name, decimal_text(e.value, 4));
      text += "\n";
    }
  }
  return text + geometry_text(image);
}

std::string method_text(const ResectionReport& report) {
  switch (report.kind) {
    case ResectionReport::Kind::kCollinearity:
      if (report.images.size() == 2)
        return fmt::format("double-image resection by collinearity: both images at once, {} iterations",
                           report.iterations);
      return fmt::format("space resection by collinearity, {}{}, {} iterations",
                         counted_text(report.images.size(), "image"), report.images.size() == 1 ? "" : " at once",
                         report.iterations);
    case ResectionReport::Kind::kLinear:
      return "pose of a known camera by linear equations, all points of equal weight, without iterations";
    case ResectionReport::Kind::kDlt:
      return fmt::format("direct linear transformation, 11 parameters, {} iterations", report.iterations);
    case ResectionReport::Kind::kPlane:
      return fmt::format("direct linear transformation of a plane, 8 parameters, {} iterations", report.iterations);
    case ResectionReport::Kind::kStation:
      break;
  }
  return "plane resection of a station from directions";
}

std::string suspect_text(const ResectionReport& report) {
  const ResectionReport::Mark* worst = nullptr;
  std::size_t tests = 0;
  for (const ResectionReport::Mark& mark : report.marks) tests += mark.is_rejected ? 0 : report.is_station() ? 1 : 2;
  for (const ResectionReport::Mark& mark : report.marks)
    if (!mark.is_rejected && (!worst || mark.w.cwiseAbs().maxCoeff() > worst->w.cwiseAbs().maxCoeff())) worst = &mark;
  if (!worst || report.variance.redundancy <= 0) return "";
  const double w = worst->w.cwiseAbs().maxCoeff();
  return largest_test_text(report.variance, tests, w, worst->point, worst->image);
}

}  // namespace

std::string resection_text(const ResectionReport& report) {
  std::string text = method_text(report) + "\n" + variance_text(report.variance);
  for (const ResectionReport::Image& image : report.images) text += image_text(report, image);
  text += "residuals, measured minus computed:\n" + indented_rows(marks_table(report));
  if (!report.tie_points.empty()) text += "tie points:\n" + indented_rows(points_table(report));
  for (const ResectionReport::Mark& mark : report.marks)
    if (mark.is_rejected)
      text += fmt::format("point {} in {} takes no part: it is off by {:.3g} {}\n", mark.point, mark.image,
                          mark.misfit.norm(), report.unit);
  return text + suspect_text(report) + findings_text(report.findings);
}

std::vector<NamedTable> resection_tables(const ResectionReport& report) {
  std::vector<NamedTable> tables{{"orientation.txt", orientation_table(report)},
                                 {"residuals.txt", marks_table(report)}};
  if (report.images.size() == 1) add_image_tables(report.images[0], report.unit, tables);
  if (!report.tie_points.empty()) tables.push_back({"points.txt", points_table(report)});
  if (TextTable rays = rays_table(report); !rays.rows.empty()) tables.push_back({"rays.txt", std::move(rays)});
  return tables;
}

}  // namespace collinea
