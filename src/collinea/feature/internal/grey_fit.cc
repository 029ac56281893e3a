// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/internal/grey_fit.h"

namespace collinea {

using Eigen::MatrixXd;
using Eigen::VectorXd;

std::optional<MatrixXd> grey_fit::correlated_moments(const GreyWindow& window, const Equations& e) {
  const auto sum_over = [&](int dx, int dy, const auto& act) {
    for (int y = std::max(0, -dy); y < std::min(window.height, window.height - dy); ++y)
      for (int x = std::max(0, -dx); x < std::min(window.width, window.width - dx); ++x)
        act(y * window.width + x, (y + dy) * window.width + x + dx);
  };
  const int count = window.count_used();
  const double variance = e.residuals.squaredNorm() / count;
  const auto correlation = [&](int dx, int dy) {
    double sum = 0;
    sum_over(dx, dy, [&](int i, int j) { sum += e.residuals[i] * e.residuals[j]; });
    return sum / (count * variance);
  };
  if (!(variance > 0) || std::max(correlation(1, 0), correlation(0, 1)) < 3 / std::sqrt(count)) return std::nullopt;
  auto spread = e.design;  // C A
  spread.setZero();
  for (int dy = -3; dy <= 3; ++dy)
    for (int dx = -3; dx <= 3; ++dx) {
      const double taper = (1 - std::abs(dx) / 4.0) * (1 - std::abs(dy) / 4.0);
      const double weight = dx == 0 && dy == 0 ? 1 : taper * correlation(dx, dy);
      sum_over(dx, dy, [&](int i, int j) { spread.row(i) += weight * e.design.row(j); });
    }
  return e.design.transpose() * spread;
}

std::optional<GreyFit> grey_fit_at(const GreyWindow& window, const grey_fit::Equations& e, const VectorXd& unknowns,
                                   Eigen::Index n) {
  const VectorXd scale = e.design.colwise().norm().cwiseMax(1e-300);
  const MatrixXd scaled = e.design * scale.cwiseInverse().asDiagonal();
  const MatrixXd normals = (scaled.transpose() * scaled).topLeftCorner(n, n);
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(normals);
  if (!(eigen.eigenvalues()[0] > 1e-9)) return std::nullopt;
  const MatrixXd inverse = scale.head(n).cwiseInverse().asDiagonal() * eigen.eigenvectors() *
                           eigen.eigenvalues().cwiseInverse().asDiagonal() * eigen.eigenvectors().transpose() *
                           scale.head(n).cwiseInverse().asDiagonal();
  GreyFit out{.unknowns = unknowns};
  out.redundancy = window.count_used() - int(n);
  out.residual_squares = e.residuals.squaredNorm();
  const double variance = out.residual_squares / out.redundancy;
  out.sigma_grey = std::sqrt(variance);
  out.cofactors = MatrixXd::Zero(unknowns.size(), unknowns.size());
  out.cofactors.topLeftCorner(n, n) = variance * inverse;
  if (const auto moments = grey_fit::correlated_moments(window, e)) {
    out.has_correlated_residuals = true;
    const MatrixXd spread = variance * inverse * moments->topLeftCorner(n, n) * inverse;
    if (spread.topLeftCorner<2, 2>().trace() > out.cofactors.topLeftCorner<2, 2>().trace())
      out.cofactors.topLeftCorner(n, n) = spread;
  }
  return out;
}

}  // namespace collinea
