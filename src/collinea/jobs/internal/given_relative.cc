// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/internal/given_relative.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "collinea/base/file.h"
#include "collinea/geometry/rotation.h"
#include "collinea/io/number_rows.h"
#include "collinea/io/text_table.h"
#include "collinea/jobs/internal/exterior_table.h"
#include "collinea/jobs/internal/fundamental_file.h"
#include "collinea/jobs/internal/given_pair.h"
#include "collinea/jobs/internal/orientation_findings.h"
#include "collinea/jobs/internal/out_folder.h"
#include "collinea/jobs/internal/pair_points.h"
#include "collinea/report/findings_text.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kRounding = 1e-3;  // of correlations written with three decimals
using Names = std::array<const char*, 5>;
constexpr Names kDependent{"by", "bz", "omega", "phi", "kappa"},
    kSymmetric{"phi1", "kappa1", "omega2", "phi2", "kappa2"};

// What is given, as a motion with the covariance of [changed(), base].
struct Given {
  RelativeForm form = RelativeForm::kDependent;
  std::array<Rigid3, 2> poses;  // the first image, or its ground, is the world
  Rigid3 motion;
  Matrix6 covariance = Matrix6::Zero();
  double base = 1;
  bool base_is_given = false;
  std::vector<std::string> images{"left", "right"};
};

// Elements with their standard deviations and correlations, lengths in bases and angles in radians.
struct Elements {
  RelativeForm form = RelativeForm::kDependent;
  double bx = 1;
  Vector5 values = Vector5::Zero(), sigmas = Vector5::Zero();
  Matrix5 correlations = Matrix5::Identity();

  [[nodiscard]] int lengths() const { return form == RelativeForm::kDependent ? 2 : 0; }
  [[nodiscard]] const Names& names() const { return form == RelativeForm::kDependent ? kDependent : kSymmetric; }
};

Result<Given> given_by(const Elements& elements, std::optional<double> base_m) {
  Given out;
  out.form = elements.form;
  const Vector5& v = elements.values;
  Matrix5 by_change;
  if (elements.form == RelativeForm::kDependent) {
    out.motion = motion_of(DependentElements{elements.bx, v(0), v(1), v(2), v(3), v(4)});
    by_change = dependent_by_change(out.motion);
  } else {
    out.motion = motion_of(SymmetricElements{v(0), v(1), v(2), v(3), v(4)});
    by_change = symmetric_by_change(out.motion);
  }
  const Eigen::FullPivLU<Matrix5> solver(by_change);
  if (!by_change.allFinite() || !solver.isInvertible())
    return fail(Errc::kBadInput, "these elements are singular: phi of 90 degrees, or a base along the view",
                {"given"_option});
  const Matrix5 of_elements = elements.sigmas.asDiagonal() * elements.correlations * elements.sigmas.asDiagonal();
  const Matrix5 back = solver.inverse();
  out.covariance.topLeftCorner<5, 5>() = back * of_elements * back.transpose();
  out.base = base_m.value_or(1);
  out.base_is_given = base_m.has_value();
  out.poses[1] = out.motion;
  out.poses[1].translation *= out.base;
  return out;
}

// "dependent:0.03,-0.02,0.6,-0.7,1.1", with five standard deviations behind them or without.
Result<std::optional<Elements>> typed(const std::string& text) {
  Elements out;
  const std::size_t colon = text.find(':');
  if (text.starts_with("symmetric:"))
    out.form = RelativeForm::kSymmetric;
  else if (!text.starts_with("dependent:"))
    return std::optional<Elements>();
  COLLINEA_TRY(const auto numbers, parse_numbers(text.substr(colon + 1)));
  if (numbers.size() != 5 && numbers.size() != 10)
    return fail(Errc::kBadInput,
                fmt::format("five elements are wanted, or ten numbers with their standard deviations; there are {}",
                            numbers.size()),
                {"given"_option});
  for (int i = 0; i < 5; ++i) {
    const double unit = i < out.lengths() ? 1 : kDegree;
    out.values(i) = unit * numbers[static_cast<std::size_t>(i)];
    if (numbers.size() == 10) out.sigmas(i) = unit * numbers[static_cast<std::size_t>(i + 5)];
  }
  if (out.sigmas.minCoeff() < 0) return fail(Errc::kBadInput, "a standard deviation below zero", {"given"_option});
  return std::optional<Elements>(out);
}

// A table as parameters.txt: of both forms the dependent one counts, which states the sign of bx.
Result<Elements> elements_of(const TextTable& table) {
  Elements out;
  COLLINEA_TRY(const auto forms, table.words("form"));
  COLLINEA_TRY(const auto names, table.words("element"));
  COLLINEA_TRY(const auto values, table.numbers("value", ""));
  COLLINEA_TRY(const auto sigmas, table.numbers_or("sigma", "", 0));
  const bool is_dependent = std::ranges::find(forms, "dependent") != forms.end();
  out.form = is_dependent ? RelativeForm::kDependent : RelativeForm::kSymmetric;
  std::array<int, 5> found{};
  for (std::size_t row = 0; row < names.size(); ++row) {
    if (forms[row] != (is_dependent ? "dependent" : "symmetric")) continue;
    if (names[row] == "bx") out.bx = values[row];
    const auto at = std::ranges::find(out.names(), names[row]) - out.names().begin();
    if (at == 5) continue;
    const double unit = at < out.lengths() ? 1 : kDegree;
    out.values(at) = unit * values[row];
    out.sigmas(at) = unit * sigmas[row];
    ++found[static_cast<std::size_t>(at)];
  }
  for (std::size_t i = 0; i < 5; ++i)
    if (found[i] != 1)
      return fail(Errc::kBadFormat, fmt::format("element {} is there {} times", out.names()[i], found[i]));
  if (!(out.sigmas.minCoeff() >= 0)) return fail(Errc::kBadFormat, "a sigma below zero");
  if (std::abs(out.bx) != 1) return fail(Errc::kBadFormat, "bx is neither 1 nor -1");
  return out;
}

// A table as correlations.txt.
Result<> read_correlations(const fs::path& path, Elements& elements) {
  const auto in_file = [&](Error e) { return std::move(e).within(path.string()); };
  COLLINEA_TRY(const TextTable table, read_text_table(path));
  COLLINEA_TRY(const auto forms, table.words("form").map_error(in_file));
  COLLINEA_TRY(const auto first, table.words("element").map_error(in_file));
  COLLINEA_TRY(const auto second, table.words("other").map_error(in_file));
  COLLINEA_TRY(const auto values, table.numbers("correlation", "").map_error(in_file));
  const Names& names = elements.names();
  for (std::size_t row = 0; row < forms.size(); ++row) {
    if (forms[row] != word_of(elements.form)) continue;
    const auto i = std::ranges::find(names, first[row]) - names.begin(),
               k = std::ranges::find(names, second[row]) - names.begin();
    if (i == 5 || k == 5 || i == k)
      return fail(Errc::kBadFormat, fmt::format("{}: row {}: no two elements", path.string(), row + 1));
    elements.correlations(i, k) = elements.correlations(k, i) = values[row];
  }
  const Eigen::SelfAdjointEigenSolver<Matrix5> solver(elements.correlations);
  if (!(solver.eigenvalues()(0) > -kRounding))
    return fail(Errc::kBadFormat, path.string() + ": its correlations contradict each other");
  elements.correlations =
      solver.eigenvectors() * solver.eigenvalues().cwiseMax(0).asDiagonal() * solver.eigenvectors().transpose();
  return {};
}

Result<Given> of_exterior(const fs::path& path, const TextTable& rows, const RelativePairOptions& options) {
  if (options.base_m || options.given_correlations)
    return fail(Errc::kBadInput, "the table of exterior orientations states the base and the correlations",
                {"given"_option, "base_m"_option, "given_correlations"_option});
  COLLINEA_TRY(const ExteriorTable table, read_exterior_table(path));
  COLLINEA_TRY(const auto names, rows.words("image"));
  if (names.size() != 2)
    return fail(Errc::kBadInput, fmt::format("{}: two images are wanted, left and right", path.string()));
  const auto pair = pair_of_poses(table.images.at(names[0]), table.images.at(names[1]));
  if (!pair) return fail(Errc::kIllPosed, path.string() + ": both images have the same projection centre");
  Given out;
  out.form = RelativeForm::kExterior;
  out.poses = {pair->poses[0].cam_from_world, pair->poses[1].cam_from_world};
  out.motion = pair->second_from_first;
  out.covariance = pair->covariance_with_base;
  out.base = pair->base;
  out.base_is_given = table.is_metric;
  out.images = names;
  return out;
}

Result<Given> read_given(const RelativePairOptions& options) {
  COLLINEA_TRY(std::optional<Elements> elements, typed(*options.given));
  if (!elements) {
    const fs::path path(*options.given);
    const auto in_file = [&](Error e) { return std::move(e).within(path.string()); };
    COLLINEA_TRY(const TextTable table, read_text_table(path));
    if (!table.has("form")) return of_exterior(path, table, options);
    COLLINEA_TRY(elements, elements_of(table).map_error(in_file));
  }
  if (options.given_correlations) COLLINEA_TRY(read_correlations(*options.given_correlations, *elements));
  return given_by(*elements, options.base_m);
}

// Of the four motions with the same coplanarity that which is given.
int in_front_of_both(const Rigid3& motion, std::span<const PairPoint> points) {
  constexpr double kAlike = 1e-9;  // of unit vectors; the others are half a turn or the other way off
  for (const RelativeSolution& one : relative_solutions(motion, points))
    if ((base_in_first(one.second_from_first) - base_in_first(motion)).norm() < kAlike &&
        angle_between(one.second_from_first.rotation, motion.rotation) < kAlike)
      return one.in_front;
  return 0;
}

Result<> write_tables(const RelativeReport& report, const fs::path& folder) {
  COLLINEA_TRY(make_out_folder(folder));
  COLLINEA_TRY(write_file(folder / "parameters.txt", text_of(relative_parameter_table(report))));
  COLLINEA_TRY(write_file(folder / "correlations.txt", text_of(relative_correlation_table(report))));
  COLLINEA_TRY(write_file(folder / "exterior.txt", text_of(relative_exterior_table(report))));
  if (report.names.empty()) return {};
  COLLINEA_TRY(write_fundamental(report, folder));
  COLLINEA_TRY(write_file(folder / "coplanarity.txt", text_of(relative_coplanarity_table(report))));
  return write_file(folder / "findings.json", findings_json_text(report.findings));
}

}  // namespace

Result<RelativeReport> compare_with_given(const fs::path& measurements, const RelativePairOptions& options) {
  if (options.distances)
    return fail(Errc::kBadInput, "distances are of a solution, and the orientation is given",
                {"given"_option, "distances"_option});
  COLLINEA_TRY(const Given given, read_given(options));
  RelativeReport report;
  report.is_given = true;
  report.given_form = given.form;
  report.options = options.adjustment;
  report.base = given.base;
  report.base_is_given = given.base_is_given;
  report.orientation.second_from_first = given.motion;
  report.orientation.covariance = given.covariance.topLeftCorner<5, 5>();
  set_right_pose(given.covariance, report);
  if (!measurements.empty()) {
    const auto in_file = [&](Error e) { return std::move(e).within(measurements.string()); };
    COLLINEA_TRY(const TextTable table, read_text_table(measurements));
    COLLINEA_TRY(read_pair_points(table, options, report).map_error(in_file));
    report.options.sigma_known = report.sigma_is_given && !options.estimate_sigma;
    report.coplanarity = given_coplanarity(report.points, given.poses, report.orientation.covariance);
    report.orientation.used = static_cast<int>(report.points.size());
    report.orientation.in_front = in_front_of_both(given.motion, report.points);
    report.findings = given_relative_findings(report);
  }
  if (options.out) COLLINEA_TRY(write_tables(report, *options.out));
  return report;
}

}  // namespace collinea
