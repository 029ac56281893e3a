// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <optional>

namespace collinea {

/// Normal equations of a robust cost in the nine entries (row by row) of a 3x3 matrix that relates two pictures.
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
  double cost = 0;  ///< [px^2]
  Eigen::Matrix<double, Chart::kFreedom, Chart::kFreedom> hessian;  ///< at the answer, in the coordinates of the chart
};

/// Damped Gauss-Newton over matrices of a certain kind (essential, rank 2, rotation ...). A Chart knows the matrix it stands for,
/// the 9 x kFreedom derivative of its entries (`tangent`), and the matrix after a small step (`moved`); the sum over the points is made
/// once in the nine entries, whatever the kind. Nothing when the cost is not finite or the equations are singular.
template <class Chart, class NormalAt>
std::optional<MatrixFit<Chart>> fit_matrix(const Chart& start, const NormalAt& normal_at, int max_iterations) {
  constexpr int k = Chart::kFreedom;
  using Square = Eigen::Matrix<double, k, k>;
  using Step = Eigen::Matrix<double, k, 1>;
  Chart best = start;
  MatrixNormal normal = normal_at(best.matrix());
  if (!std::isfinite(normal.cost)) return std::nullopt;
  Eigen::Matrix<double, 9, k> tangent = best.tangent();
  double damping = 1e-6;
  for (int iteration = 0; iteration < max_iterations && damping < 1e3; ++iteration) {
    Square system = tangent.transpose() * (normal.hessian.template selfadjointView<Eigen::Lower>() * tangent);
    system.diagonal() *= 1 + damping;
    const Step step = system.ldlt().solve(-(tangent.transpose() * normal.gradient));
    if (!step.allFinite()) return std::nullopt;
    const Chart candidate = best.moved(step);
    const MatrixNormal at_candidate = normal_at(candidate.matrix());
    if (!(at_candidate.cost <= normal.cost)) {
      damping = std::max(1e-3, damping * 10);
      continue;
    }
    const bool settled = normal.cost - at_candidate.cost <= 1e-6 * normal.cost && step.norm() < 1e-6;
    best = candidate;
    normal = at_candidate;
    tangent = best.tangent();
    damping = std::max(1e-9, damping / 10);
    if (settled) break;
  }
  const Square hessian = tangent.transpose() * (normal.hessian.template selfadjointView<Eigen::Lower>() * tangent);
  return MatrixFit<Chart>{best, normal.cost, hessian};
}

}  // namespace collinea
