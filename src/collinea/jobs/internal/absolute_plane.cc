// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/internal/absolute_plane.h"

#include <cmath>
#include <numbers>

#include "collinea/geometry/plane_similarity.h"
#include "collinea/jobs/internal/rejection.h"

namespace collinea {
namespace {

using Eigen::Vector3d;
constexpr double kDegrees = 180 / std::numbers::pi;

std::vector<Estimate> estimates_of(const PlaneSimilarity& p, double factor, const char* x, const char* y) {
  const auto sigma = [&](int i) { return factor * std::sqrt(p.covariance(i, i)); };
  return {{x, "m", p.shift.x(), sigma(0)},
          {y, "m", p.shift.y(), sigma(1)},
          {"scale", "", p.scale, sigma(2)},
          {"angle", "deg", p.angle_rad * kDegrees, sigma(3) * kDegrees}};
}

// Points known in plan that take part, and their indices among those in common.
struct Pairs {
  std::vector<PlanePair> pairs;
  std::vector<std::size_t> indices;
};

Pairs pairs_of(const AbsoluteTables& control) {
  Pairs out;
  for (const std::size_t k : control.fit.used()) {
    const AbsoluteControl& pair = control.fit.pairs[k];
    if (!pair.has_plan) continue;
    out.pairs.push_back({pair.in_model.head<2>(), pair.in_ground.head<2>(), pair.model_covariance.topLeftCorner<2, 2>(),
                         pair.ground_covariance.topLeftCorner<2, 2>()});
    out.indices.push_back(k);
  }
  return out;
}

std::optional<PlaneSimilarityFit> fitted(AbsoluteTables& control, const OrientAbsoluteOptions& options) {
  return fitted_with_rejection(
      Rejection{options.reject, control.fit.sigmas_are_stated, options.alpha, 2},
      [&] { return fit_plane_similarity(pairs_of(control).pairs); },
      [](const PlaneSimilarityFit& fit) -> const auto& { return fit.w; },
      [&](std::size_t k) { return control.fit.is_rejected[pairs_of(control).indices[k]]; });
}

Result<> leave_out_by_median(AbsoluteTables& control, std::uint64_t seed) {
  const Pairs all = pairs_of(control);
  const auto wrong = contradicting_in_plane(all.pairs, seed);
  if (!wrong)
    return fail(Errc::kIllPosed,
                "the least median of squares needs four points known in plan, of which those that agree are apart",
                {"least_median"_option});
  for (const std::size_t k : *wrong) control.fit.is_rejected[all.indices[k]] = true;
  return {};
}

Vector3d lifted(const Eigen::Vector2d& v) { return {v.x(), v.y(), 0}; }

// Of a point of the model in plan, by the similarity and by the point itself.
Eigen::Matrix2d covariance_on_ground(const PlaneSimilarity& fit, const Eigen::Vector2d& u,
                                     const Eigen::Matrix2d& of_point) {
  const Eigen::Vector2d arm = fit.matrix() * u;
  Eigen::Matrix<double, 2, 4> by;
  by << 1, 0, arm.x() / fit.scale, -arm.y(), 0, 1, arm.y() / fit.scale, arm.x();
  return by * fit.covariance * by.transpose() + fit.matrix() * of_point * fit.matrix().transpose();
}

void add_points(const AbsoluteTables& control, const PlaneSimilarityFit& fit, const Pairs& used,
                AbsoluteReport& report) {
  const double factor = report.variance.factor();
  std::size_t next = 0;
  for (std::size_t k = 0; k < control.fit.pairs.size(); ++k) {
    const AbsoluteControl& pair = control.fit.pairs[k];
    AbsoluteReport::Point point{control.fit.names[k],
                                Vector3d::Zero(),
                                Vector3d::Zero(),
                                Vector3d::Zero(),
                                Vector3d::Zero(),
                                pair.has_plan,
                                false,
                                control.fit.is_check[k],
                                control.fit.is_rejected[k]};
    point.misfit = lifted(pair.in_ground.head<2>() - fit.b_from_a * pair.in_model.head<2>());
    if (next < used.indices.size() && used.indices[next] == k) {
      point.sigma = factor * lifted(fit.sigmas[next]);
      point.redundancy = lifted(fit.redundancies[next]);
      point.w = lifted(fit.w[next]) / report.variance.of_tests();
      ++next;
    } else if (pair.has_plan) {
      const Eigen::Matrix2d covariance =
          covariance_on_ground(fit.b_from_a, pair.in_model.head<2>(), pair.model_covariance.topLeftCorner<2, 2>()) +
          pair.ground_covariance.topLeftCorner<2, 2>();
      const Eigen::Vector2d sigma = covariance.diagonal().cwiseSqrt();
      point.sigma = factor * lifted(sigma);
      point.w = lifted(point.misfit.head<2>().cwiseQuotient(sigma)) / report.variance.of_tests();
    }
    report.points.push_back(std::move(point));
  }
}

void add_ground(const AbsoluteTables& control, const PlaneSimilarityFit& fit, AbsoluteReport& report) {
  const double factor = report.variance.factor();
  for (std::size_t i = 0; i < control.model.names.size(); ++i) {
    const Eigen::Vector2d u = control.model.points[i].head<2>();
    const Eigen::Matrix2d covariance =
        covariance_on_ground(fit.b_from_a, u, control.model.covariances[i].topLeftCorner<2, 2>());
    report.ground.push_back(
        {control.model.names[i], lifted(fit.b_from_a * u), lifted(factor * covariance.diagonal().cwiseSqrt())});
  }
}

}  // namespace

Result<AbsoluteReport> orient_in_plane(AbsoluteTables& control, const OrientAbsoluteOptions& options) {
  if (options.least_median) COLLINEA_TRY(leave_out_by_median(control, options.seed));
  const auto fit = fitted(control, options);
  if (!fit)
    return fail(Errc::kIllPosed,
                "a plane similarity needs two points apart that are known in plan, with sigmas above 0");
  const Pairs used = pairs_of(control);
  AbsoluteReport report;
  report.is_plane = true;
  report.variance = {fit->sigma0, fit->redundancy, control.fit.sigmas_are_stated, options.alpha};
  const double factor = report.variance.factor();
  report.parameters = estimates_of(fit->b_from_a, factor, "X0", "Y0");
  report.inverse_parameters = estimates_of(inverse(fit->b_from_a), factor, "U0", "V0");
  report.covariance = factor * factor * fit->b_from_a.covariance;
  report.full = static_cast<int>(used.pairs.size());
  add_points(control, *fit, used, report);
  add_ground(control, *fit, report);
  return report;
}

}  // namespace collinea
