// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/internal/tie_marginal.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "collinea/math/quantiles.h"

namespace collinea {
namespace {

constexpr int kShells = 400, kSteps = 400;
constexpr double kFarthest = 7;  // asinh of what is tabulated: 550 scales

// Probability that Student's length of two directions is below r, and the length for a probability.
double within_of(const ErrorDistribution& d, double r) {
  const double q = r * r / (d.scale * d.scale), nu = d.degrees_of_freedom;
  return 1 - (d.is_normal() ? std::exp(-q / 2) : std::pow(1 + q / nu, -nu / 2));
}
double length_of(const ErrorDistribution& d, double p) {
  const double nu = d.degrees_of_freedom;
  return d.scale * std::sqrt(d.is_normal() ? -2 * std::log1p(-p) : nu * (std::pow(1 - p, -2 / nu) - 1));
}

// Share of the directions in which the coordinate of a length is below x.
double share_below(double x, double length) { return x >= length ? 1 : 2 / std::numbers::pi * std::asin(x / length); }

// Probability of a smaller absolute coordinate, of one direction: that is the length itself.
double within_line(const ErrorDistribution& d, double x) {
  const auto student = [&](double at) {
    if (d.is_normal()) return std::erf(at / d.scale / std::numbers::sqrt2);
    const double nu = d.degrees_of_freedom;
    return 1 - incomplete_beta(nu / 2, 0.5, nu / (nu + at * at / (d.scale * d.scale)));
  };
  const double of_all = std::isfinite(d.largest) ? student(d.largest) : 1;
  const double gross = d.gross_radius > 0 ? std::min(1.0, x / d.gross_radius) : 1;
  return (1 - d.gross_share) * std::min(1.0, student(x) / of_all) + d.gross_share * gross;
}

}  // namespace

TieMarginal::TieMarginal(const ErrorDistribution& errors) : step_(kFarthest / kSteps), scale_(errors.scale) {
  std::vector<double> student(kShells), gross(kShells);
  const double all = std::isfinite(errors.largest) ? within_of(errors, errors.largest) : 1;
  for (std::size_t k = 0; k < kShells; ++k) {
    const double p = (double(k) + 0.5) / kShells;
    student[k] = length_of(errors, p * all);
    gross[k] = errors.gross_radius * std::sqrt(p);
  }
  for (int i = 0; i <= kSteps; ++i) {
    const double x = scale_ * std::sinh(i * step_);
    double of_student = 0, of_gross = 0;
    for (std::size_t k = 0; k < kShells; ++k) {
      of_student += share_below(x, student[k]) / kShells;
      of_gross += share_below(x, gross[k]) / kShells;
    }
    within_.push_back(errors.directions == 1 ? within_line(errors, x)
                                             : (1 - errors.gross_share) * of_student + errors.gross_share * of_gross);
  }
}

double TieMarginal::operator()(double coordinate) const {
  const double at = std::asinh(std::abs(coordinate) / scale_) / step_;
  double within = within_.back();
  if (at < kSteps) {
    const auto i = std::size_t(at);
    within = within_[i] + (at - double(i)) * (within_[i + 1] - within_[i]);
  }
  return coordinate < 0 ? (1 - within) / 2 : (1 + within) / 2;
}

}  // namespace collinea
