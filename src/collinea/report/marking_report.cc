// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/marking_report.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace collinea {
namespace {

std::string line_of(const PredictedMark& one, const Block& block) {
  const Eigen::Vector2d variances = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(one.covariance).eigenvalues();
  return fmt::format("{:<24} {:>9.2f} {:>9.2f} {:>9.2f} {:>9.2f} {:>14} {:>7}\n", block.images.at(one.image).file,
                     one.pixel.x(), one.pixel.y(), std::sqrt(variances[1]), std::sqrt(std::max(0.0, variances[0])),
                     one.sigma_after_m ? fmt::format("{:.4f}", *one.sigma_after_m) : "-",
                     one.marked   ? "yes"
                     : one.hidden ? "hidden"
                                  : "no");
}

std::string tests_text(const MarksReport& report) {
  const MarkedPoint& marked = *report.marks.marked;
  const Eigen::Vector3d sigma = marked.covariance.diagonal().cwiseSqrt();
  std::string text = fmt::format(
      "\nFrom its marks alone: standard deviations {:.4f} {:.4f} {:.4f} m (east, north, height), sigma0 {:.2f}.\n",
      sigma.x(), sigma.y(), sigma.z(), marked.sigma0);
  text += fmt::format("{:<24} {:>9} {:>9} {:>7} {:>7} {:>11} {:>11}\n", "mark", "v_col_px", "v_row_px", "w_col",
                      "w_row", "MDB_col_px", "MDB_row_px");
  for (std::size_t i = 0; i < marked.tests.size(); ++i) {
    const PointMarkTest& test = marked.tests[i];
    text += fmt::format("{:<24} {:>9.2f} {:>9.2f} {:>7.2f} {:>7.2f} {:>11.2f} {:>11.2f}\n",
                        report.block.images.at(report.marks.marked_images[i]).file, test.residual_px.x(),
                        test.residual_px.y(), test.w.x(), test.w.y(), test.detectable_px.x(), test.detectable_px.y());
  }
  return text;
}

}  // namespace

std::string predicted_marks_text(const MarksReport& report) {
  if (report.marks.predicted.empty()) return "No oriented image shows " + report.point.name + ".\n";
  std::string text = fmt::format("{:<24} {:>9} {:>9} {:>9} {:>9} {:>14} {:>7}\n", "image", "column_px", "row_px",
                                 "major_px", "minor_px", "sigma_after_m", "marked");
  for (const PredictedMark& one : report.marks.predicted) text += line_of(one, report.block);
  if (report.marks.given_disagrees)
    text += "The given coordinates contradict the marks and were not used: check both, and the datum.\n";
  for (const ImageId image : report.marks.contradicting)
    text += fmt::format("The mark in {} contradicts the others and was not used: check it.\n",
                        report.block.images.at(image).file);
  if (report.marks.marked) text += tests_text(report);
  return text;
}

std::string refined_mark_text(const RefinedMark& mark) {
  return fmt::format("{} column {:.3f} row {:.3f} px, standard deviations {:.3f} {:.3f} px, correlation {:.2f}\n",
                     word_of(mark.kind), mark.pixel.x(), mark.pixel.y(), std::sqrt(mark.covariance(0, 0)),
                     std::sqrt(mark.covariance(1, 1)),
                     mark.covariance(0, 1) / std::sqrt(mark.covariance(0, 0) * mark.covariance(1, 1)));
}

}  // namespace collinea
