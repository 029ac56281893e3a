// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/pair_report.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "collinea/epipolar/relative_elements.h"
#include "collinea/report/findings_text.h"
#include "collinea/report/internal/level_table.h"

namespace collinea {
namespace {

constexpr std::size_t kMostRejected = 20;  // printed: all are in rejected.txt
constexpr double kDegree = std::numbers::pi / 180;

std::string search_text(const PairReport& report) {
  std::string text = "interest points, matched there and back by correlation\n";
  text += fmt::format("  {:>7} {:>8} {:>8} {:>9} {:>12} {:>12}\n", "shrink", "interest", "matched", "agreeing",
                      "px_mean[px]", "py_mean[px]");
  for (const PairPointStage& stage : report.search)
    text += fmt::format("  {:>7} {:>8} {:>8} {:>9} {:>12.1f} {:>12.1f}\n", stage.shrink, stage.interest, stage.matched,
                        stage.agreeing, stage.parallax_px.x(), stage.parallax_px.y());
  return text;
}

// The base by its components over the largest one, which is 1.
std::string base_text(const RelativeOrientation& orientation) {
  const Eigen::Vector3d base = base_in_first(orientation.second_from_first);
  Eigen::Index unit = 0;
  base.cwiseAbs().maxCoeff(&unit);
  const Eigen::Matrix<double, 3, 2> tangents = tangents_of(base);
  const Eigen::Matrix3d covariance =
      tangents * orientation.stated_covariance().bottomRightCorner<2, 2>() * tangents.transpose();
  const char* const names[] = {"bx", "by", "bz"};
  std::string text;
  for (Eigen::Index i = 0; i < 3; ++i) {
    if (i == unit) {
      if (unit != 0) text += fmt::format("  {:<6} {:>11.5f}\n", names[i], base[i] < 0 ? -1.0 : 1.0);
      continue;
    }
    Eigen::Vector3d by = Eigen::Vector3d::Unit(i) / std::abs(base[unit]);
    by[unit] = -base[i] / (base[unit] * std::abs(base[unit]));
    text += fmt::format("  {:<6} {:>11.5f} +- {:.5f}\n", names[i], base[i] / std::abs(base[unit]),
                        std::sqrt(by.dot(covariance * by)));
  }
  return text;
}

std::string map_text(const PairMap& map) {
  const double cells = double(map.width) * map.height;
  return fmt::format(
      "surface model and orthophoto: {} x {} cells of {:.4g} m, {:.0f} % measured, {:.0f} % interpolated, {:.0f} % "
      "painted; "
      "sigma of measured heights {:.3f} m, by matching alone {:.3f} m\n",
      map.width, map.height, map.cell_m, 100 * double(map.measured_cells) / cells,
      100 * double(map.interpolated_cells) / cells, 100 * double(map.painted_cells) / cells, map.mean_sigma_m,
      map.mean_sigma_relative_m);
}

std::string orientation_head(const PairOrientation& of, int shrink, bool is_given) {
  const std::string where = of.shrink == shrink ? "" : fmt::format(" at 1/{} of the size", of.shrink);
  return fmt::format("relative orientation {}by {}{}: {} points, {} rejected, sigma0 {:.3f} px\n",
                     is_given ? "as given, points " : "", of.by, where, of.points, of.rejected, of.sigma0_px);
}

std::string orientation_text(const PairOrientation& of, int shrink, bool is_given) {
  std::string text = orientation_head(of, shrink, is_given);
  const auto elements = dependent_elements(of.orientation.second_from_first);
  if (!elements) return text + "  the base lies across x: no elements of the dependent form\n";
  const Matrix5 by = dependent_by_change(of.orientation.second_from_first);
  const Matrix5 covariance = by * of.orientation.stated_covariance() * by.transpose();
  const Vector5 values = elements->values();
  const char* const names[] = {"by", "bz", "omega", "phi", "kappa"};
  text += base_text(of.orientation);
  for (int i = 2; i < 5; ++i) {
    const double unit = i < 2 ? 1 : kDegree;
    text += fmt::format("  {:<6} {:>11.5f} +- {:.5f}{}\n", names[i], values[i] / unit,
                        std::sqrt(covariance(i, i)) / unit, i < 2 ? "" : " deg");
  }
  return text;
}

// Their pixels in the middle are as large as those of the images.
std::string epipolar_text(const PairReport& report) {
  const Camera &left = report.epipolar.left, &right = report.epipolar.right;
  std::string text = fmt::format(
      "epipolar images: {} x {} and {} x {} px, principal distance {:.1f} px; y-parallax of the points {:.3f} px RMS; "
      "a row is known to {:.2f} px\n",
      left.width_px, left.height_px, right.width_px, right.height_px, left.focal_px(), report.y_parallax_rms_px,
      report.row_sigma_px);
  text += fmt::format("  {}, principal points {:.1f}, {:.1f} and {:.1f}, {:.1f} px", word_of(report.resampling),
                      left.params[Camera::kCx], left.params[Camera::kCy], right.params[Camera::kCx],
                      right.params[Camera::kCy]);
  if (report.pixel_um)
    text += fmt::format("; pixel {:.3f} um, principal distance {:.3f} mm", *report.pixel_um,
                        1e-3 * *report.pixel_um * left.focal_px());
  return text + "\n";
}

std::string surface_text(const PairReport& report) {
  std::string text = fmt::format("surface: {}, {} points", word_of(report.surface), report.surface_points);
  text += fmt::format("; median sigma {:.3f} px, {:.4f} {} in depth\n", report.median_sigma_px, report.median_sigma_z,
                      report.has_base ? "m" : "bases");
  if (!report.levels.empty()) text += level_table(report.levels);
  return text;
}

// The last one with all that is known of it, those before it in short.
std::string relative_orientations_text(const PairReport& report) {
  std::string text;
  for (std::size_t i = 0; i < report.orientations.size(); ++i) {
    const bool is_last = i + 1 == report.orientations.size();
    text += is_last && report.relative ? orientation_head(report.orientations[i], report.shrink, report.is_given) +
                                             relative_summary_text(*report.relative, kMostRejected)
                                       : orientation_text(report.orientations[i], report.shrink, report.is_given);
  }
  return text;
}

std::string exterior_text(const PairReport& report) {
  std::string text;
  for (const PairExterior& one : report.exterior)
    if (!one.elements.empty())
      text += fmt::format("exterior orientation of {} {}{}:\n", one.image, report.is_given ? "as given, " : "",
                          report.absolute ? "on the ground" : "in the model (x right, y up, z backwards)") +
              estimates_text(one.elements);
  return text;
}

}  // namespace

std::string pair_text(const PairReport& report) {
  std::string text = fmt::format("images worked on at 1/{} of their size, {} x {} px\n", report.shrink,
                                 report.left_width_px, report.left_height_px);
  for (std::size_t i = 0; i < report.scans.size(); ++i)
    text += fmt::format("{} scan: {} fiducial marks, {} misread, {:.1f} um RMS, pixel {:.3f} um\n",
                        i == 0 ? "left" : "right", report.scans[i].marks, report.scans[i].misread,
                        report.scans[i].rms_um, report.scans[i].pixel_um);
  text += search_text(report);
  text += relative_orientations_text(report);
  text += epipolar_text(report);
  text += surface_text(report);
  if (report.control) text += absolute_text(*report.control);
  text += exterior_text(report);
  if (report.map) text += map_text(*report.map);
  return text + findings_text(report.findings);
}

}  // namespace collinea
