// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/internal/noise.h"

#include <cmath>

#include "collinea/math/median.h"

namespace collinea {
namespace {

constexpr double kUnitScale_px = 2;    // where both errors are alike: measured on terrestrial and aerial blocks
constexpr double kFalseAlarm = 0.001;  // of calling an error gross, as in the tests of the adjustment
constexpr std::size_t kFewest = 100, kMost = 20000;

// Scale of the Student distribution with nu degrees of freedom by maximum likelihood, squared.
double squared_scale(const std::vector<double>& q, double nu, double start) {
  constexpr int kRounds = 100;
  double scale2 = start;
  for (int round = 0; round < kRounds; ++round) {
    double sum = 0;
    for (const double one : q) sum += (nu + 2) * one / (nu + one / scale2);
    const double next = sum / (2 * static_cast<double>(q.size()));
    const bool settled = std::abs(next - scale2) < 1e-4 * scale2;
    scale2 = next;
    if (settled) break;
  }
  return scale2;
}

double log_likelihood(const std::vector<double>& q, double nu, double scale2) {
  double sum = 0;
  for (const double one : q) sum += std::log1p(one / (nu * scale2));
  return -std::log(scale2) - (nu + 2) / 2 * sum / static_cast<double>(q.size());
}

}  // namespace

double sigma_factor(double scale_px) { return std::sqrt((1 + std::pow(scale_px / kUnitScale_px, 2)) / 2); }

std::optional<TieNoise> fit_noise(const std::vector<double>& squared_px2) {
  if (squared_px2.size() < kFewest) return std::nullopt;
  std::vector<double> q;
  const std::size_t stride = (squared_px2.size() + kMost - 1) / kMost;
  for (std::size_t i = 0; i < squared_px2.size(); i += stride) q.push_back(squared_px2[i]);
  double scale2 = median(q);
  if (!(scale2 > 0)) return std::nullopt;
  TieNoise best;
  double best_likelihood = -INFINITY;
  for (const double nu : {2.0, 3.0, 4.0, 6.0, 10.0, 20.0}) {
    scale2 = squared_scale(q, nu, scale2);
    const double likelihood = log_likelihood(q, nu, scale2);
    if (likelihood <= best_likelihood) break;  // it has one maximum
    best_likelihood = likelihood;
    best = {std::sqrt(scale2 * nu / (nu + 2)), Loss::kCauchy, std::sqrt(nu + 2),
            std::sqrt((nu + 2) * (std::pow(kFalseAlarm, -2 / nu) - 1))};
  }
  return best;
}

}  // namespace collinea
