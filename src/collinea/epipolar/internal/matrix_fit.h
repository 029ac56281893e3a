// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <concepts>
#include <optional>

namespace collinea {

/// Normal equations of a robust cost in the nine entries (row by row) of a 3x3 matrix that relates two images.
struct MatrixNormal {
  Eigen::Matrix<double, 9, 9> hessian = Eigen::Matrix<double, 9, 9>::Zero();  ///< lower half filled
  Eigen::Matrix<double, 9, 1> gradient = Eigen::Matrix<double, 9, 1>::Zero();
  double cost = 0;  ///< [px^2]
};

[[nodiscard]] inline Eigen::Matrix<double, 9, 1> by_rows(const Eigen::Matrix3d& m) {
  Eigen::Matrix<double, 9, 1> v;
  v << m.row(0).transpose(), m.row(1).transpose(), m.row(2).transpose();
  return v;
}

template <class Chart>
struct MatrixFit {
  Chart value;
  double cost = 0;                                                  ///< [px^2]
  Eigen::Matrix<double, Chart::kFreedom, Chart::kFreedom> hessian;  ///< at the answer, in the coordinates of the chart
};

/// A chart whose coordinates are known beforehand to some degree: cost [px^2] and its halved derivatives.
template <class Chart>
concept HasPrior = requires(const Chart& chart, Eigen::Matrix<double, Chart::kFreedom, Chart::kFreedom>& hessian,
                            Eigen::Matrix<double, Chart::kFreedom, 1>& gradient) {
  { chart.prior_cost() } -> std::convertible_to<double>;
  chart.add_prior(hessian, gradient);
};

/// The normal equations in the coordinates of a chart.
template <class Chart>
struct ChartNormal {
  Eigen::Matrix<double, Chart::kFreedom, Chart::kFreedom> hessian;
  Eigen::Matrix<double, Chart::kFreedom, 1> gradient;
  double cost;

  ChartNormal(const Chart& chart, const MatrixNormal& normal) : cost(normal.cost) {
    const Eigen::Matrix<double, 9, Chart::kFreedom> tangent = chart.tangent();
    hessian = tangent.transpose() * (normal.hessian.selfadjointView<Eigen::Lower>() * tangent);
    gradient = tangent.transpose() * normal.gradient;
    if constexpr (HasPrior<Chart>) {
      chart.add_prior(hessian, gradient);
      cost += chart.prior_cost();
    }
  }
};

/// Damped Gauss-Newton over matrices of a certain kind (essential, rank 2, rotation ...). A Chart knows the matrix it
/// stands for, the 9 x kFreedom derivative of its entries (`tangent`), and the matrix after a small step (`moved`); the
/// sum over the points is made once in the nine entries, whatever the kind. Nothing when the cost is not finite or the
/// equations are singular.
template <class Chart, class NormalAt>
std::optional<MatrixFit<Chart>> fit_matrix(const Chart& start, const NormalAt& normal_at, int max_iterations) {
  Chart best = start;
  ChartNormal<Chart> normal(best, normal_at(best.matrix()));
  if (!std::isfinite(normal.cost)) return std::nullopt;
  double damping = 1e-6;
  for (int iteration = 0; iteration < max_iterations && damping < 1e3; ++iteration) {
    auto system = normal.hessian;
    system.diagonal() *= 1 + damping;
    const Eigen::Matrix<double, Chart::kFreedom, 1> step = system.ldlt().solve(-normal.gradient);
    if (!step.allFinite()) return std::nullopt;
    const Chart candidate = best.moved(step);
    const ChartNormal<Chart> at_candidate(candidate, normal_at(candidate.matrix()));
    if (!(at_candidate.cost <= normal.cost)) {
      damping = std::max(1e-3, damping * 10);
      continue;
    }
    const bool settled = normal.cost - at_candidate.cost <= 1e-6 * normal.cost && step.norm() < 1e-6;
    best = candidate;
    normal = at_candidate;
    damping = std::max(1e-9, damping / 10);
    if (settled) break;
  }
  return MatrixFit<Chart>{best, normal.cost, normal.hessian};
}

}  // namespace collinea
