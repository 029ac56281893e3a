// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/internal/error_mixture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>
#include <vector>

#include "collinea/math/median.h"
#include "collinea/math/quantiles.h"

namespace collinea {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::size_t kFewest = 200;
constexpr double kFarthest = 50;        // core scales: errors beyond are gross whatever else is, and tell nothing of it
constexpr double kBinsPerFactorE = 12;  // of squared length: a bin is represented by its mean
constexpr double kBeyondChance = 10.83;  // chi-squared with one degree of freedom, 0.1 %
constexpr int kMostRounds = 200;
constexpr double kSettled = 1e-5;
// Tried values of 1 / nu. Between them the likelihood is taken for a parabola.
constexpr std::array<double, 14> kInverse = {0,   0.02, 0.05, 0.08, 0.12, 0.16, 0.2,
                                             0.25, 0.3,  0.36, 0.43, 0.5,  0.7,  1};

// Errors of nearly the same length, and of the same number of directions.
struct Bin {
  double squared = 0, count = 0;
  int directions = 0;
};

double log_density(double squared, int d, double scale2, double nu) {
  const double n = d;
  if (nu == kInfinity) return -0.5 * (squared / scale2 + n * std::log(2 * std::numbers::pi * scale2));
  const double constant = d == 2 ? -std::log(2 * std::numbers::pi)
                                 : std::lgamma((nu + 1) / 2) - std::lgamma(nu / 2) - 0.5 * std::log(nu * std::numbers::pi);
  return constant - 0.5 * n * std::log(scale2) - (nu + n) / 2 * std::log1p(squared / (nu * scale2));
}

double uniform_density(int d, double radius) {
  return radius <= 0 ? 0 : d == 2 ? 1 / (std::numbers::pi * radius * radius) : 1 / (2 * radius);
}

std::vector<Bin> binned(std::span<const CheckedError> errors) {
  std::map<std::pair<int, long>, Bin> bins;
  for (const CheckedError& one : errors) {
    const long key = one.squared > 1e-12 ? std::lround(kBinsPerFactorE * std::log(one.squared)) : -1000000;
    Bin& bin = bins[{one.directions, key}];
    bin.squared += one.squared;
    bin.count += 1;
    bin.directions = one.directions;
  }
  std::vector<Bin> list;
  for (auto& [key, bin] : bins) {
    bin.squared /= bin.count;
    list.push_back(bin);
  }
  return list;
}

struct Fit {
  double scale2 = 1, share = 0, log_likelihood = -kInfinity;
};

// Scale and share of gross errors for given degrees of freedom. A share that begins at zero stays zero.
Fit fit_for(const std::vector<Bin>& bins, double nu, double radius, Fit fit) {
  for (int round = 0; round < kMostRounds; ++round) {
    double good = 0, all = 0, weighted = 0, directions = 0, likelihood = 0;
    for (const Bin& bin : bins) {
      const int d = bin.directions;
      const double student = (1 - fit.share) * std::exp(log_density(bin.squared, d, fit.scale2, nu)),
                   gross = fit.share * uniform_density(d, radius), both = student + gross;
      const double z = bin.count * (both > 0 ? student / both : 0);
      likelihood += bin.count * std::log(std::max(both, 1e-300));
      all += bin.count;
      good += z;
      directions += z * d;
      weighted += z * (nu == kInfinity ? 1 : (nu + d) / (nu + bin.squared / fit.scale2)) * bin.squared;
    }
    const double scale2 = weighted / directions, share = fit.share > 0 ? std::max(1 - good / all, 1e-9) : 0;
    const bool settled = std::abs(scale2 - fit.scale2) < kSettled * fit.scale2 && std::abs(share - fit.share) < kSettled;
    fit = {scale2, share, likelihood};
    if (settled || !(scale2 > 0)) break;
  }
  return fit;
}

struct Best {
  double inverse = 0;
  Fit fit;
};

// The best degrees of freedom, with or without gross errors.
Best best_of(const std::vector<Bin>& bins, double radius, double start2, double share) {
  std::vector<Fit> tried;
  Fit fit{start2, share};
  std::size_t best = 0;
  for (const double inverse : kInverse) {
    tried.push_back(fit = fit_for(bins, 1 / inverse, radius, fit));
    if (fit.log_likelihood > tried[best].log_likelihood) best = tried.size() - 1;
  }
  Best found{kInverse[best], tried[best]};
  if (best == 0 || best + 1 == tried.size()) return found;
  const double left = kInverse[best] - kInverse[best - 1], right = kInverse[best + 1] - kInverse[best];
  const double slope_left = (tried[best].log_likelihood - tried[best - 1].log_likelihood) / left,
               slope_right = (tried[best + 1].log_likelihood - tried[best].log_likelihood) / right;
  const double top = kInverse[best] + 0.5 * (slope_left * right + slope_right * left) / (slope_left - slope_right);
  const Fit between = fit_for(bins, 1 / top, radius, tried[best]);
  return between.log_likelihood > found.fit.log_likelihood ? Best{top, between} : found;
}

bool is_better(double log_likelihood, double than) { return 2 * (log_likelihood - than) > kBeyondChance; }

}  // namespace

double ErrorDistribution::sigma() const {
  if (is_normal()) return scale;
  return degrees_of_freedom > 2 ? scale * std::sqrt(degrees_of_freedom / (degrees_of_freedom - 2)) : kInfinity;
}

double ErrorDistribution::gross_probability(const CheckedError& error) const {
  if (gross_share <= 0 || error.directions == 0) return 0;
  const double gross = gross_share * uniform_density(error.directions, gross_radius);
  const double other =
      (1 - gross_share) * std::exp(log_density(error.squared, error.directions, scale * scale, degrees_of_freedom));
  return gross / (gross + other);
}

double ErrorDistribution::limit(double alpha) const { return scale * student_limit(alpha, degrees_of_freedom); }

std::optional<ErrorDistribution> fit_errors(std::span<const CheckedError> errors) {
  std::vector<CheckedError> checked;
  for (const CheckedError& one : errors)
    if (one.directions > 0 && std::isfinite(one.squared)) checked.push_back(one);
  if (checked.size() < kFewest) return std::nullopt;
  std::vector<double> per_direction;
  for (const CheckedError& one : checked) per_direction.push_back(one.squared / one.directions);
  const double core2 = median(per_direction) / 0.6;  // 0.45 and 0.69 of normal errors
  if (!(core2 > 1e-12)) return std::nullopt;
  double largest = 0, coordinates = 0;
  for (const CheckedError& one : checked) {
    largest = std::max(largest, std::min(std::sqrt(one.squared), kFarthest * std::sqrt(core2)));
    coordinates += one.directions;
  }
  const std::vector<Bin> bins = binned(checked);

  constexpr double kFirstShare = 0.01;
  const Best mixed = best_of(bins, largest, core2, kFirstShare), pure = best_of(bins, largest, core2, 0);
  const bool any_gross = is_better(mixed.fit.log_likelihood, pure.fit.log_likelihood);
  const Best& best = any_gross ? mixed : pure;
  const Fit normal = fit_for(bins, kInfinity, largest, {core2, any_gross ? kFirstShare : 0});
  const bool is_student = is_better(best.fit.log_likelihood, normal.log_likelihood);
  const Fit& fit = is_student ? best.fit : normal;
  ErrorDistribution found{.scale = std::sqrt(fit.scale2), .gross_share = fit.share, .gross_radius = largest};
  if (is_student) found.degrees_of_freedom = 1 / best.inverse;
  constexpr double kChance = 3;
  if (!is_student && std::abs(found.scale - 1) < kChance / std::sqrt(2 * coordinates)) found.scale = 1;
  return found;
}

}  // namespace collinea
