// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/internal/control_fit.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <ranges>

#include "collinea/jobs/internal/rejection.h"

namespace collinea {
namespace {

using Eigen::Vector3d;
constexpr double kDegrees = 180 / std::numbers::pi;

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

}  // namespace

std::vector<std::size_t> ControlFit::used() const {
  std::vector<std::size_t> out;
  for (std::size_t k = 0; k < pairs.size(); ++k)
    if (!is_check[k] && !is_rejected[k]) out.push_back(k);
  return out;
}

std::vector<AbsoluteControl> ControlFit::used_pairs() const {
  std::vector<AbsoluteControl> out;
  for (const std::size_t k : used()) out.push_back(pairs[k]);
  return out;
}

Result<AbsoluteOrientation> fitted(const ControlFit& control) {
  const std::vector<std::size_t> used = control.used();
  const std::vector<AbsoluteControl> pairs = control.used_pairs();
  Eigen::MatrixXd part;
  if (control.model_covariance) {
    const auto size = static_cast<Eigen::Index>(3 * used.size());
    part.resize(size, size);
    for (std::size_t a = 0; a < used.size(); ++a)
      for (std::size_t b = 0; b < used.size(); ++b)
        part.block<3, 3>(Eigen::Index(3 * a), Eigen::Index(3 * b)) =
            control.model_covariance->block<3, 3>(Eigen::Index(3 * used[a]), Eigen::Index(3 * used[b]));
  }
  const Eigen::MatrixXd* const covariance = control.model_covariance ? &part : nullptr;
  if (!control.closed_form) return absolute_orientation(pairs, {.start = {}, .model_covariance = covariance});
  const auto found = closed_orientation(pairs, *control.closed_form, covariance);
  if (!found)
    return fail(Errc::kIllPosed,
                fmt::format("a closed form needs three full points that do not lie on a line, with sigmas above 0 on "
                            "one side; there are {} full ones",
                            pairs.size()),
                {"method"_option});
  return *found;
}

Result<AbsoluteOrientation> fitted_with_rejection(ControlFit& control, bool reject, double alpha) {
  return fitted_with_rejection(
      Rejection{reject, control.sigmas_are_stated, alpha, 1}, [&] { return fitted(control); },
      [](const AbsoluteOrientation& found) { return found.residuals | std::views::transform(&ControlResidual::w); },
      [&](std::size_t k) { return control.is_rejected[control.used()[k]]; });
}

AbsoluteReport control_report(const ControlFit& control, const AbsoluteOrientation& found,
                              const VarianceTest& variance) {
  AbsoluteReport report;
  report.variance = variance;
  report.solutions = found.solutions;
  const double factor = variance.factor();
  const AbsoluteParameters parameters = parameters_of(found);
  report.parameters = estimates_of(parameters, factor);
  report.covariance = factor * factor * parameters.covariance;
  std::size_t next = 0;
  for (std::size_t k = 0; k < control.pairs.size(); ++k) {
    const AbsoluteControl& pair = control.pairs[k];
    AbsoluteReport::Point point{control.names[k], Vector3d::Zero(),    Vector3d::Zero(),
                                Vector3d::Zero(), Vector3d::Zero(),    pair.has_plan,
                                pair.has_height,  control.is_check[k], control.is_rejected[k]};
    if (point.is_check || point.is_rejected) {
      const GroundPoint at = on_ground(found, pair.in_model, pair.model_covariance);
      point.misfit = pair.in_ground - at.position;
      const Vector3d sigma = (at.covariance + pair.ground_covariance).diagonal().cwiseSqrt();
      point.sigma = factor * sigma;
      point.w = point.misfit.cwiseQuotient(sigma) / variance.of_tests();
    } else {
      const ControlResidual& residual = found.residuals[next++];
      point.misfit = residual.misfit;
      point.sigma = factor * residual.sigma;
      point.redundancy = residual.redundancy;
      point.w = residual.w / variance.of_tests();
    }
    if (!point.is_check && !point.is_rejected)
      ++(pair.is_full() ? report.full : pair.has_plan ? report.plan : report.height);
    report.points.push_back(std::move(point));
  }
  return report;
}

}  // namespace collinea
