// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/absolute.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "collinea/geometry/closed_orientation.h"
#include "collinea/jobs/internal/absolute_plane.h"
#include "collinea/jobs/internal/absolute_tables.h"

namespace collinea {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
constexpr double kDegrees = 180 / std::numbers::pi;

std::vector<AbsoluteControl> pairs_of(const AbsoluteTables& control, const std::vector<std::size_t>& used) {
  std::vector<AbsoluteControl> pairs;
  for (const std::size_t k : used) pairs.push_back(control.pairs[k]);
  return pairs;
}

Result<AbsoluteOrientation> in_closed_form(const std::vector<AbsoluteControl>& pairs, AbsoluteMethod method,
                                           const MatrixXd* model_covariance) {
  const ClosedForm form = method == AbsoluteMethod::kUmeyama      ? ClosedForm::kUmeyama
                          : method == AbsoluteMethod::kQuaternion ? ClosedForm::kQuaternion
                                                                  : ClosedForm::kRodrigues;
  const auto found = closed_orientation(pairs, form, model_covariance);
  if (!found)
    return fail(Errc::kIllPosed,
                fmt::format("a closed form needs three full points that do not lie on a line, with sigmas above 0 on "
                            "one side; there are {} full ones",
                            pairs.size()),
                {"method"_option});
  return *found;
}

Result<AbsoluteOrientation> fitted(const AbsoluteTables& control, const std::vector<std::size_t>& used,
                                   AbsoluteMethod method) {
  const std::vector<AbsoluteControl> pairs = pairs_of(control, used);
  MatrixXd part;
  if (control.model.full) {
    const auto size = static_cast<Eigen::Index>(3 * used.size());
    part.resize(size, size);
    for (std::size_t a = 0; a < used.size(); ++a)
      for (std::size_t b = 0; b < used.size(); ++b)
        part.block<3, 3>(Eigen::Index(3 * a), Eigen::Index(3 * b)) = control.model.full->block<3, 3>(
            Eigen::Index(3 * control.common[used[a]]), Eigen::Index(3 * control.common[used[b]]));
  }
  const MatrixXd* full = control.model.full ? &part : nullptr;
  if (method != AbsoluteMethod::kLeastSquares) return in_closed_form(pairs, method, full);
  return absolute_orientation(pairs, {.start = {}, .model_covariance = full});
}

// The orientation, and again without the worst as long as its test is beyond the limit and enough is left.
Result<AbsoluteOrientation> fitted_with_rejection(AbsoluteTables& control, const OrientAbsoluteOptions& options) {
  while (true) {
    const std::vector<std::size_t> used = control.used();
    COLLINEA_TRY(const AbsoluteOrientation found, fitted(control, used, options.method));
    const VarianceTest variance{found.sigma0, found.redundancy, control.sigmas_are_stated, options.alpha};
    if (!options.reject || found.redundancy <= 1) return found;
    std::size_t worst = 0;
    double largest = 0;
    for (std::size_t k = 0; k < used.size(); ++k)
      if (const double w = found.residuals[k].w.cwiseAbs().maxCoeff() / variance.factor(); w > largest) {
        largest = w;
        worst = used[k];
      }
    if (!(largest > variance.limit())) return found;
    control.is_rejected[worst] = true;
    if (!fitted(control, control.used(), options.method)) {  // not enough is left without it
      control.is_rejected[worst] = false;
      return found;
    }
  }
}

std::vector<Estimate> estimates_of(const AbsoluteParameters& p, double factor) {
  const auto sigma = [&](int i, double unit) { return factor * unit * std::sqrt(p.covariance(i, i)); };
  return {{"X0", "m", p.origin_on_ground.x(), sigma(0, 1)},
          {"Y0", "m", p.origin_on_ground.y(), sigma(1, 1)},
          {"Z0", "m", p.origin_on_ground.z(), sigma(2, 1)},
          {"omega", "deg", p.omega_rad * kDegrees, sigma(3, kDegrees)},
          {"phi", "deg", p.phi_rad * kDegrees, sigma(4, kDegrees)},
          {"kappa", "deg", p.kappa_rad * kDegrees, sigma(5, kDegrees)},
          {"scale", "", p.scale, sigma(6, 1)}};
}

AbsoluteReport report_of(const AbsoluteTables& control, const AbsoluteOrientation& found,
                         const VarianceTest& variance) {
  AbsoluteReport report;
  report.variance = variance;
  report.solutions = found.solutions;
  const double factor = variance.factor();
  const AbsoluteParameters parameters = parameters_of(found);
  report.parameters = estimates_of(parameters, factor);
  report.covariance = parameters.covariance;
  std::size_t next = 0;
  for (std::size_t k = 0; k < control.pairs.size(); ++k) {
    const AbsoluteControl& pair = control.pairs[k];
    AbsoluteReport::Point point{control.model.names[control.common[k]],
                                Vector3d::Zero(),
                                Vector3d::Zero(),
                                Vector3d::Zero(),
                                Vector3d::Zero(),
                                pair.has_plan,
                                pair.has_height,
                                control.is_check[k],
                                control.is_rejected[k]};
    if (point.is_check || point.is_rejected) {
      const GroundPoint at = on_ground(found, pair.in_model, pair.model_covariance);
      point.misfit = pair.in_ground - at.position;
      point.sigma = factor * (at.covariance + pair.ground_covariance).diagonal().cwiseSqrt();
      point.w = point.misfit.cwiseQuotient(point.sigma);
    } else {
      const ControlResidual& residual = found.residuals[next++];
      point.misfit = residual.misfit;
      point.sigma = factor * residual.sigma;
      point.redundancy = residual.redundancy;
      point.w = residual.w / factor;
    }
    if (!point.is_check && !point.is_rejected)
      ++(pair.is_full() ? report.full : pair.has_plan ? report.plan : report.height);
    report.points.push_back(std::move(point));
  }
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
  const bool is_closed = options.method != AbsoluteMethod::kLeastSquares;
  if (is_closed)  // what is known in part cannot take part
    for (std::size_t k = 0; k < control.pairs.size(); ++k)
      control.is_check[k] = control.is_check[k] || !control.pairs[k].is_full();
  if (options.least_median) {
    const std::vector<std::size_t> used = control.used();
    const auto wrong = contradicting_control(pairs_of(control, used), options.seed);
    if (!wrong)
      return fail(Errc::kIllPosed,
                  "the least median of squares needs four full points, of which those that agree are not on a line",
                  {"least_median"_option});
    for (const std::size_t k : *wrong) control.is_rejected[used[k]] = true;
  }
  COLLINEA_TRY(const AbsoluteOrientation found, fitted_with_rejection(control, options));
  AbsoluteReport report =
      report_of(control, found, {found.sigma0, found.redundancy, control.sigmas_are_stated, options.alpha});
  report.iterations = found.iterations;
  if (is_closed) report.closed_form = word_of(options.method);
  return report;
}

}  // namespace

Result<AbsoluteReport> orient_absolutely(const std::filesystem::path& model, const std::filesystem::path& ground,
                                         const OrientAbsoluteOptions& options) {
  COLLINEA_TRY(validate(options));
  COLLINEA_TRY(AbsoluteTables control, read_absolute_tables(model, ground, options));
  return options.method == AbsoluteMethod::kPlane ? orient_in_plane(control, options) : in_space(control, options);
}

}  // namespace collinea
