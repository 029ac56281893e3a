// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/absolute.h"

#include "collinea/jobs/internal/absolute_plane.h"
#include "collinea/jobs/internal/absolute_tables.h"
#include "collinea/jobs/internal/orientation_findings.h"

namespace collinea {
namespace {

using Eigen::Matrix3d;

std::optional<ClosedForm> closed_form(AbsoluteMethod method) {
  if (method == AbsoluteMethod::kUmeyama) return ClosedForm::kUmeyama;
  if (method == AbsoluteMethod::kQuaternion) return ClosedForm::kQuaternion;
  if (method == AbsoluteMethod::kRodrigues) return ClosedForm::kRodrigues;
  return std::nullopt;
}

AbsoluteReport report_of(const AbsoluteTables& control, const AbsoluteOrientation& found,
                         const VarianceTest& variance) {
  AbsoluteReport report = control_report(control.fit, found, variance);
  const double factor = variance.factor();
  for (std::size_t i = 0; i < control.model.names.size(); ++i) {
    const Matrix3d own = control.model.full
                             ? Matrix3d(control.model.full->block<3, 3>(Eigen::Index(3 * i), Eigen::Index(3 * i)))
                             : control.model.covariances[i];
    const GroundPoint at = on_ground(found, control.model.points[i], own);
    report.ground.push_back({control.model.names[i], at.position, factor * at.covariance.diagonal().cwiseSqrt()});
  }
  return report;
}

Result<AbsoluteReport> in_space(AbsoluteTables& control, const OrientAbsoluteOptions& options) {
  ControlFit& fit = control.fit;
  fit.closed_form = closed_form(options.method);
  if (fit.closed_form)  // what is known in part cannot take part
    for (std::size_t k = 0; k < fit.pairs.size(); ++k) fit.is_check[k] = fit.is_check[k] || !fit.pairs[k].is_full();
  if (options.least_median) {
    const std::vector<std::size_t> used = fit.used();
    const auto wrong = contradicting_control(fit.used_pairs(), options.seed);
    if (!wrong)
      return fail(Errc::kIllPosed,
                  "the least median of squares needs four full points, of which those that agree are not on a line",
                  {"least_median"_option});
    for (const std::size_t k : *wrong) fit.is_rejected[used[k]] = true;
  }
  COLLINEA_TRY(const AbsoluteOrientation found, fitted_with_rejection(fit, options.reject, options.alpha));
  AbsoluteReport report =
      report_of(control, found, {found.sigma0, found.redundancy, fit.sigmas_are_stated, options.alpha});
  report.iterations = found.iterations;
  if (fit.closed_form) report.closed_form = word_of(options.method);
  return report;
}

}  // namespace

Result<AbsoluteReport> orient_absolutely(const std::filesystem::path& model, const std::filesystem::path& ground,
                                         const OrientAbsoluteOptions& options) {
  COLLINEA_TRY(validate(options));
  COLLINEA_TRY(AbsoluteTables control, read_absolute_tables(model, ground, options));
  COLLINEA_TRY(AbsoluteReport report, options.method == AbsoluteMethod::kPlane ? orient_in_plane(control, options)
                                                                               : in_space(control, options));
  report.findings = absolute_findings(report, control.fit);
  return report;
}

}  // namespace collinea
