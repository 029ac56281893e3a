// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/factorisation_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "collinea/io/text.h"
#include "collinea/math/fisher.h"
#include "collinea/report/findings_text.h"

namespace collinea {
namespace {

using Euclidean = FactorisationReport::Euclidean;

std::string digits(double value) { return fmt::format("{:.9g}", value); }

TextTable cameras_table(const FactorisationReport& report) {
  TextTable table;
  table.remarks = {fmt::format("(x, y, 1) ~ M P, x and y in {}, y {}", report.unit, report.y_up ? "up" : "down")};
  table.columns = {{"image", ""}};
  for (int row = 1; row <= 3; ++row)
    for (int column = 1; column <= 4; ++column) table.columns.push_back({fmt::format("m{}{}", row, column), ""});
  for (std::size_t i = 0; i < report.images.size(); ++i) {
    std::vector<std::string> row{report.images[i]};
    for (int k = 0; k < 12; ++k) row.push_back(exact(report.projective.matrices[i](k / 4, k % 4)));
    table.rows.push_back(std::move(row));
  }
  return table;
}

TextTable projective_points_table(const FactorisationReport& report) {
  TextTable table;
  table.columns = {{"point", ""}, {"P1", ""}, {"P2", ""}, {"P3", ""}, {"P4", ""}};
  for (std::size_t p = 0; p < report.points.size(); ++p) {
    std::vector<std::string> row{report.points[p]};
    for (int k = 0; k < 4; ++k) row.push_back(exact(report.projective.points(k, static_cast<Eigen::Index>(p))));
    table.rows.push_back(std::move(row));
  }
  return table;
}

TextTable projective_residuals_table(const FactorisationReport& report) {
  TextTable table;
  table.columns = {{"image", ""}, {"point", ""}, {"dx", report.unit}, {"dy", report.unit}};
  for (std::size_t i = 0; i < report.images.size(); ++i)
    for (std::size_t p = 0; p < report.points.size(); ++p) {
      const Eigen::Vector2d off = report.projective.misfits[i].col(static_cast<Eigen::Index>(p));
      table.rows.push_back({report.images[i], report.points[p], decimal_text(off.x(), report.y_up ? 5 : 3),
                            decimal_text(off.y(), report.y_up ? 5 : 3)});
    }
  return table;
}

TextTable pairs_table(const FactorisationReport& report) {
  TextTable table;
  table.columns = {{"first", ""}, {"second", ""}, {"focal", report.unit}};
  for (int row = 1; row <= 3; ++row)
    for (int column = 1; column <= 3; ++column) table.columns.push_back({fmt::format("f{}{}", row, column), ""});
  for (const PairFundamental& pair : report.pairs) {
    std::vector<std::string> row{report.images[pair.first], report.images[pair.second],
                                 pair.focal ? decimal_text(*pair.focal, 3) : "-"};
    for (int k = 0; k < 9; ++k) row.push_back(digits(pair.fundamental(k / 3, k % 3)));
    table.rows.push_back(std::move(row));
  }
  return table;
}

TextTable images_table(const FactorisationReport& report, const Euclidean& euclidean) {
  TextTable table = exterior_table(report.images, euclidean.exterior);
  table.remarks = {
      fmt::format("unit of length: the distance of {} from {}", report.images[report.unit_base], report.images[0])};
  return table;
}

TextTable points_table(const FactorisationReport& report, const Euclidean& euclidean) {
  TextTable table;
  table.columns = {{"point", ""}};
  for (const char* name : {"U", "V", "W", "sigma_U", "sigma_V", "sigma_W"}) table.columns.push_back({name, ""});
  for (std::size_t p = 0; p < report.points.size(); ++p) {
    std::vector<std::string> row{report.points[p]};
    for (const double value : euclidean.points[p]) row.push_back(digits(value));
    for (const double value : euclidean.sigma_points[p]) row.push_back(fmt::format("{:.3g}", value));
    table.rows.push_back(std::move(row));
  }
  return table;
}

TextTable residuals_table(const FactorisationReport& report, const Euclidean& euclidean) {
  TextTable table;
  table.columns = {{"image", ""}, {"point", ""}, {"dx", report.unit}, {"dy", report.unit},
                   {"w_x", ""},   {"w_y", ""},   {"r_x", ""},         {"r_y", ""}};
  for (std::size_t k = 0; k < euclidean.marks.size(); ++k) {
    const BundleMarkTest& mark = euclidean.marks[k];
    std::vector<std::string> row{report.images[k % report.images.size()], report.points[k / report.images.size()]};
    for (const double value : mark.misfit) row.push_back(decimal_text(value, report.y_up ? 5 : 3));
    for (const Eigen::Vector2d& values : {mark.w, mark.redundancy})
      for (const double value : values) row.push_back(decimal_text(value, 2));
    table.rows.push_back(std::move(row));
  }
  return table;
}

TextTable differences_table(const FactorisationReport& report) {
  TextTable table;
  table.columns = {{"image", ""}, {"centre", ""}, {"sigma_centre", ""}, {"rotation", "deg"}, {"sigma_rotation", "deg"}};
  for (std::size_t i = 0; i < report.differences.size(); ++i) {
    const FactorisationReport::Difference& d = report.differences[i];
    table.rows.push_back({report.images[i], decimal_text(d.centre, 6), decimal_text(d.sigma_centre, 6),
                          decimal_text(d.rotation_deg, 5), decimal_text(d.sigma_rotation_deg, 5)});
  }
  return table;
}

std::string worst_text(const FactorisationReport& report, const Euclidean& euclidean) {
  if (euclidean.variance.redundancy <= 0) return "";
  std::size_t worst = 0;
  const auto largest = [&](std::size_t k) { return euclidean.marks[k].w.cwiseAbs().maxCoeff(); };
  for (std::size_t k = 1; k < euclidean.marks.size(); ++k)
    if (largest(k) > largest(worst)) worst = k;
  return largest_test_text(euclidean.variance, 2 * euclidean.marks.size(), largest(worst),
                           report.points[worst / report.images.size()], report.images[worst % report.images.size()]);
}

std::string projective_text(const FactorisationReport& report) {
  const ProjectiveModel& model = report.projective;
  std::string text =
      fmt::format("projective factorisation: {}, {} in all of them", counted_text(report.images.size(), "image"),
                  counted_text(report.points.size(), "point"));
  if (!report.left_out.empty()) text += fmt::format("; {} left out, not in all images", report.left_out.size());
  if (!report.rejected.empty()) text += fmt::format("\nrejected points: {}", fmt::join(report.rejected, " "));
  text += fmt::format(
      "\nmeasurement matrix: fourth singular value {:.2e} of the first, fifth {:.2e} (rank 4 has none); {} "
      "alternations, {} iterations in the images\n",
      model.fourth, model.fifth, model.alternations, model.iterations);
  return text + variance_text(report.projective_variance);
}

std::string fundamentals_text(const FactorisationReport& report) {
  std::vector<double> focals;
  for (const PairFundamental& pair : report.pairs)
    if (pair.focal) focals.push_back(*pair.focal);
  std::sort(focals.begin(), focals.end());
  std::string text = fmt::format("fundamental matrices: {}", counted_text(report.pairs.size(), "pair"));
  text += focals.empty()
              ? "; none of them states a principal distance"
              : fmt::format("; principal distances that {} of them state: {:.6g} to {:.6g} {}, median {:.6g}",
                            focals.size(), focals.front(), focals.back(), report.unit, focals[focals.size() / 2]);
  text += "\n";
  if (report.from_fundamentals.empty()) return text + "the pairs together do not state the calibration\n";
  return text + "calibration of all pairs (no standard deviations: the pairs are not independent):\n" +
         estimates_text(report.from_fundamentals);
}

std::string euclidean_text(const FactorisationReport& report, const Euclidean& euclidean) {
  std::string text = variance_text(euclidean.variance) + estimates_text(euclidean.interior);
  for (std::size_t i = 0; i < report.images.size(); ++i)
    text += fmt::format("image {}:\n", report.images[i]) + estimates_text(euclidean.exterior[i]);
  return text + fmt::format("conditioning: smallest over largest eigenvalue {:.2e}\n", euclidean.conditioning) +
         worst_text(report, euclidean);
}

// Whether one calibration for all images, or the stated one, costs more than errors of measurement allow.
std::string price_text(const std::string& what, const VarianceTest& free, const VarianceTest& bound) {
  const auto test = test_of_conditions(free, bound);
  if (!test) return "";
  return fmt::format("{}: {} conditions cost F {:.2f} (chance {:.2g}): {}\n", what, test->conditions, test->ratio,
                     test->chance, test->is_refuted() ? "refuted" : "not refuted");
}

std::string comparison_text(const FactorisationReport& report) {
  if (!report.calibrated)
    return report.why_not_calibrated.empty() ? "" : "calibrated path: " + report.why_not_calibrated + "\n";
  std::string text = "calibrated path, with the camera as stated:\n" + variance_text(report.calibrated->variance) +
                     worst_text(report, *report.calibrated);
  if (!report.self_calibrated) return text;
  text += price_text("the stated camera against the self-calibrated one", report.self_calibrated->variance,
                     report.calibrated->variance);
  return text + "self-calibrated less calibrated images, in units of the base:\n" +
         indented_rows(differences_table(report));
}

}  // namespace

std::optional<ConditionTest> test_of_conditions(const VarianceTest& free, const VarianceTest& bound) {
  ConditionTest test{bound.redundancy - free.redundancy};
  if (test.conditions <= 0 || free.redundancy <= 0) return std::nullopt;
  const double squares = bound.sigma0 * bound.sigma0 * bound.redundancy - free.sigma0 * free.sigma0 * free.redundancy;
  const double variance = free.sigmas_are_stated ? 1 : free.sigma0 * free.sigma0;
  test.ratio = std::max(0.0, squares / test.conditions / variance);
  test.chance = fisher_tail(test.ratio, test.conditions, free.sigmas_are_stated ? INFINITY : free.redundancy);
  return test;
}

std::string factorisation_text(const FactorisationReport& report) {
  std::string text = projective_text(report) + fundamentals_text(report);
  if (report.self_calibrated) {
    text += fmt::format(
        "Euclidean upgrade: equations of the absolute dual quadric fit within {:.1e}; then all bundles with one "
        "calibration, {} iterations:\n",
        report.upgrade_misfit, report.self_calibrated->iterations);
    text += euclidean_text(report, *report.self_calibrated);
    text += price_text("one calibration for all images", report.projective_variance, report.self_calibrated->variance);
  } else if (!report.why_not_euclidean.empty()) {
    text += "no Euclidean form: " + report.why_not_euclidean + "\n";
  }
  return text + comparison_text(report) + findings_text(report.findings);
}

std::vector<NamedTable> factorisation_tables(const FactorisationReport& report) {
  std::vector<NamedTable> tables{{"projective_cameras.txt", cameras_table(report)},
                                 {"projective_points.txt", projective_points_table(report)},
                                 {"projective_residuals.txt", projective_residuals_table(report)},
                                 {"pairs.txt", pairs_table(report)}};
  if (report.self_calibrated) {
    const Euclidean& euclidean = *report.self_calibrated;
    tables.push_back({"interior.txt", estimates_table(euclidean.interior)});
    tables.push_back({"exterior.txt", images_table(report, euclidean)});
    tables.push_back({"model.txt", points_table(report, euclidean)});
    tables.push_back({"residuals.txt", residuals_table(report, euclidean)});
  }
  if (report.calibrated) {
    tables.push_back({"calibrated_exterior.txt", images_table(report, *report.calibrated)});
    tables.push_back({"calibrated_model.txt", points_table(report, *report.calibrated)});
  }
  if (!report.differences.empty()) tables.push_back({"differences.txt", differences_table(report)});
  return tables;
}

}  // namespace collinea
