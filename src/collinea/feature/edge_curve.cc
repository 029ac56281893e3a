// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/edge_curve.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "collinea/feature/edge_correlation.h"

namespace collinea {
namespace {

using Eigen::Index;

constexpr double kShift_px = 1e-3;  // of the numeric derivatives
constexpr double kReach = 5;        // of correlations, times along

double covariance_of(const EdgePoint& p, const EdgePoint& q, double along_px) {
  if (&p == &q) return p.sigma_px * p.sigma_px;
  const double reach = kReach * std::max(along_px, 1e-3);
  if ((p.at - q.at).squaredNorm() > reach * reach) return 0;
  return p.sigma_px * q.sigma_px * edge_correlation(p, q, along_px);
}

Curve curve_of(std::span<const EdgePoint> edge) {
  Curve out;
  for (const EdgePoint& p : edge) out.push_back(p.at);
  return out;
}

// Radius and invariants of a closed curve; empty where it has none.
Eigen::VectorXd figures_of(const Curve& curve, int harmonics) {
  const FourierDescriptors d = fourier_descriptors(curve, true, harmonics);
  const std::vector<double> invariants = d.invariants();
  if (invariants.empty()) return {};
  Eigen::VectorXd out(Index(invariants.size()) + 1);
  out[0] = std::abs(d(1));
  out.tail(Index(invariants.size())) = Eigen::Map<const Eigen::VectorXd>(invariants.data(), Index(invariants.size()));
  return out;
}

}  // namespace

std::vector<PsiS> psi_s(std::span<const EdgePoint> edge, bool is_closed, double along_px, double window_px) {
  return psi_s(curve_of(edge), is_closed, window_px,
               [&](std::size_t i, std::size_t k) { return covariance_of(edge[i], edge[k], along_px); });
}

EdgeDescriptors edge_descriptors(std::span<const EdgePoint> edge, double along_px, int harmonics) {
  Curve curve = curve_of(edge);
  std::vector<EdgePoint> points(edge.begin(), edge.end());
  if (area_of(curve) < 0) {
    std::reverse(curve.begin(), curve.end());
    std::reverse(points.begin(), points.end());
  }
  const Eigen::VectorXd figures = figures_of(curve, harmonics);
  if (figures.size() == 0) return {};
  Eigen::MatrixXd by(figures.size(), Index(points.size()));
  for (std::size_t i = 0; i < points.size(); ++i) {
    Eigen::VectorXd sides[2];
    for (const int side : {0, 1}) {
      curve[i] = points[i].at + (side == 0 ? -kShift_px : kShift_px) * points[i].normal;
      sides[side] = figures_of(curve, harmonics);
      if (sides[side].size() != figures.size()) return {};
    }
    curve[i] = points[i].at;
    by.col(Index(i)) = (sides[1] - sides[0]) / (2 * kShift_px);
  }
  Eigen::VectorXd variances = Eigen::VectorXd::Zero(figures.size());
  for (std::size_t i = 0; i < points.size(); ++i)
    for (std::size_t k = 0; k < points.size(); ++k)
      if (const double c = covariance_of(points[i], points[k], along_px); c != 0)
        variances += c * by.col(Index(i)).cwiseProduct(by.col(Index(k)));
  const Eigen::VectorXd sigmas = variances.cwiseMax(0).cwiseSqrt();
  return {figures[0],
          sigmas[0],
          {figures.data() + 1, figures.data() + figures.size()},
          {sigmas.data() + 1, sigmas.data() + sigmas.size()}};
}

}  // namespace collinea
