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

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr std::size_t kFewestErrors = 200;
constexpr double kFarthest = 300;        // core scales: errors beyond are gross whatever the others are
constexpr double kBinsPerFactorE = 12;   // of squared length: a bin is represented by its mean
constexpr double kBeyondChance = 10.83;  // chi-squared with one degree of freedom, 0.1 %
constexpr int kMostFitRounds = 300;
constexpr double kFirstShare = 0.01;  // of gross errors, where their fit begins
// Tried values of 1 / nu. Between them the likelihood is taken for a parabola.
constexpr std::array<double, 14> kInverse = {0, 0.02, 0.05, 0.08, 0.12, 0.16, 0.2, 0.25, 0.3, 0.36, 0.43, 0.5, 0.7, 1};

// Errors of nearly the same length, and of the same number of directions.
struct Bin {
  double squared = 0, count = 0;
  int directions = 0;
};

double log_density(double squared, int d, double scale2, double nu) {
  const double n = d;
  if (nu == kInfinite) return -0.5 * (squared / scale2 + n * std::log(2 * std::numbers::pi * scale2));
  const double constant = d == 2
                              ? -std::log(2 * std::numbers::pi)
                              : std::lgamma((nu + 1) / 2) - std::lgamma(nu / 2) - 0.5 * std::log(nu * std::numbers::pi);
  return constant - 0.5 * n * std::log(scale2) - (nu + n) / 2 * std::log1p(squared / (nu * scale2));
}

// Lengths that bound the errors.
struct Radii {
  double largest = kInfinite;  // of all
  double gross = 0;            // within which gross ones are alike
};

double uniform_density(int d, double radius) {
  return radius <= 0 ? 0 : d == 2 ? 1 / (std::numbers::pi * radius * radius) : 1 / (2 * radius);
}

// What of Student's distribution lies beyond a radius: with x = nu / (nu + q / scale^2), which has the beta
// distribution of nu / 2 and d / 2. Normal errors have no tail worth counting.
struct Tail {
  double probability = 0;
  double mean_weighted = 0;  // of (nu + d) q / (nu + q / scale^2), over scale^2

  Tail(int d, double radius, double scale2, double nu) {
    if (nu == kInfinite || radius == kInfinite) return;
    const double x = nu / (nu + radius * radius / scale2), b = 0.5 * d;
    probability = incomplete_beta(nu / 2, b, x);
    if (!(probability > 1e-12)) {
      probability = 0;
      return;
    }
    mean_weighted = nu + d - nu * incomplete_beta(nu / 2 + 1, b, x) / probability;
  }
};

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
  double scale2 = 1, share = 0, log_likelihood = -kInfinite;
};

// One round of expectation and maximisation for given degrees of freedom; the likelihood is that of `fit` itself.
Fit next_fit(const std::vector<Bin>& bins, double nu, const Radii& radii, const Fit& fit) {
  const std::array<Tail, 2> tails = {Tail(1, radii.largest, fit.scale2, nu), Tail(2, radii.largest, fit.scale2, nu)};
  double good = 0, all = 0, weighted = 0, directions = 0, likelihood = 0;
  for (const Bin& bin : bins) {
    const int d = bin.directions;
    const Tail& tail = tails[static_cast<std::size_t>(d - 1)];
    const double student =
                     (1 - fit.share) * std::exp(log_density(bin.squared, d, fit.scale2, nu)) / (1 - tail.probability),
                 gross = bin.squared > radii.gross * radii.gross ? 0 : fit.share * uniform_density(d, radii.gross),
                 both = student + gross;
    const double z = bin.count * (both > 0 ? student / both : 0);
    likelihood += bin.count * std::log(std::max(both, 1e-300));
    all += bin.count;
    good += z;
    weighted += z * (nu == kInfinite ? 1 : (nu + d) / (nu + bin.squared / fit.scale2)) * bin.squared;
    // Those that were cut off, as the distribution expects them (Dempster, Laird, Rubin 1977, 4.2).
    const double missing = z * tail.probability / (1 - tail.probability);
    weighted += missing * tail.mean_weighted * fit.scale2;
    directions += (z + missing) * d;
  }
  return {weighted / directions, fit.share > 0 ? std::max(1 - good / all, 1e-9) : 0, likelihood};
}

// Scale and share of gross errors for given degrees of freedom. A share that begins at zero stays zero.
Fit fit_for(const std::vector<Bin>& bins, double nu, const Radii& radii, Fit fit, double accuracy) {
  for (int round = 0; round < kMostFitRounds; ++round) {
    const Fit next = next_fit(bins, nu, radii, fit);
    const bool settled =
        std::abs(next.scale2 - fit.scale2) < accuracy * fit.scale2 && std::abs(next.share - fit.share) < accuracy;
    fit = next;
    if (settled || !(fit.scale2 > 0)) break;
  }
  return fit;
}

constexpr double kCoarse = 3e-4, kFine = 1e-6;

// The radius of gross errors: of the largest error, its half and so on, that with which the likelihood is greatest. The
// tails of what is not gross may reach farther.
double gross_radius_of(const std::vector<Bin>& bins, double largest, double start2) {
  constexpr int kCandidates = 6;
  constexpr double kUsual = 4;                 // degrees of freedom
  const double least = 6 * std::sqrt(start2);  // gross ones within would not be told from others
  double best = largest, best_likelihood = -kInfinite, radius = largest;
  for (int i = 0; i < kCandidates && radius > least; ++i, radius /= 1.6) {
    const Fit fit = fit_for(bins, kUsual, {largest, radius}, {start2, kFirstShare}, kCoarse);
    if (fit.log_likelihood <= best_likelihood) continue;
    best = radius;
    best_likelihood = fit.log_likelihood;
  }
  return best;
}

struct Best {
  double inverse = 0;
  Fit fit;
};

// The best degrees of freedom, with or without gross errors.
Best best_of(const std::vector<Bin>& bins, const Radii& radii, double start2, double share) {
  std::vector<Fit> tried;
  Fit fit{start2, share};
  std::size_t best = 0;
  for (const double inverse : kInverse) {
    tried.push_back(fit = fit_for(bins, 1 / inverse, radii, fit, kCoarse));
    if (fit.log_likelihood > tried[best].log_likelihood) best = tried.size() - 1;
  }
  Best found{kInverse[best], fit_for(bins, 1 / kInverse[best], radii, tried[best], kFine)};
  if (best == 0 || best + 1 == tried.size()) return found;
  const double left = kInverse[best] - kInverse[best - 1], right = kInverse[best + 1] - kInverse[best];
  const double slope_left = (tried[best].log_likelihood - tried[best - 1].log_likelihood) / left,
               slope_right = (tried[best + 1].log_likelihood - tried[best].log_likelihood) / right;
  if (!(slope_left > slope_right)) return found;
  const double top = kInverse[best] + 0.5 * (slope_left * right + slope_right * left) / (slope_left - slope_right);
  const Fit between = fit_for(bins, 1 / top, radii, found.fit, kFine);
  return between.log_likelihood > found.fit.log_likelihood ? Best{top, between} : found;
}

bool is_better(double log_likelihood, double than) { return 2 * (log_likelihood - than) > kBeyondChance; }

// Probability that a coordinate in [-radius, radius] exceeds `limit`, of a Student distribution in two dimensions of
// the scale 1 that is cut off at the radius: the integral over the length l of 2 / pi acos(limit / l), by the
// trapezoidal rule in (1 + l^2 / nu)^(-nu / 2), the probability of longer ones.
double cut_tail_of_coordinate(double limit, double radius, double nu) {
  constexpr int kSteps = 200;
  const auto beyond = [&](double length) { return std::pow(1 + length * length / nu, -nu / 2); };
  const double from = beyond(limit), to = radius == kInfinite ? 0 : beyond(radius);
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double p = to + (from - to) * (i + 0.5) / kSteps, length = std::sqrt(nu * (std::pow(p, -2 / nu) - 1));
    sum += std::acos(std::min(limit / length, 1.0));
  }
  return 2 / std::numbers::pi * sum / kSteps * (from - to) / (1 - to);
}

}  // namespace

double ErrorDistribution::gross_probability(const CheckedError& error) const {
  constexpr double kRounding = 1 + 1e-9;
  if (error.directions == 0) return 0;
  if (error.squared > kRounding * largest * largest) return 1;
  if (gross_share <= 0) return 0;
  const double scale2 = scale * scale, gross = gross_share * uniform_density(error.directions, gross_radius);
  const double other = (1 - gross_share) *
                       std::exp(log_density(error.squared, error.directions, scale2, degrees_of_freedom)) /
                       (1 - Tail(error.directions, largest, scale2, degrees_of_freedom).probability);
  return gross / (gross + other);
}

double ErrorDistribution::limit(double alpha) const {
  if (is_normal()) return scale * normal_limit(alpha);
  const double nu = degrees_of_freedom, radius = largest / scale;
  if (directions == 1) {
    const double cut = Tail(1, largest, scale * scale, nu).probability;
    return scale * student_limit(alpha * (1 - cut) + cut, nu);
  }
  double low = 0, high = student_limit(alpha, nu);
  for (int halving = 0; halving < 60; ++halving) {
    const double middle = (low + high) / 2;
    (cut_tail_of_coordinate(middle, radius, nu) > alpha ? low : high) = middle;
  }
  return scale * (low + high) / 2;
}

std::optional<ErrorDistribution> fit_errors(std::span<const CheckedError> errors) {
  std::vector<double> per_direction;
  double coordinates = 0;
  for (const CheckedError& one : errors) {
    if (one.directions == 0 || !std::isfinite(one.squared)) continue;
    per_direction.push_back(one.squared / one.directions);
    coordinates += one.directions;
  }
  if (per_direction.size() < kFewestErrors) return std::nullopt;
  const double count = static_cast<double>(per_direction.size());
  const double core2 = median(per_direction) / 0.6;  // 0.45 and 0.69 of normal errors
  if (!(core2 > 1e-12)) return std::nullopt;
  std::vector<CheckedError> checked;
  double largest2 = 0;
  for (const CheckedError& one : errors) {
    if (one.directions == 0 || !(one.squared <= kFarthest * kFarthest * core2)) continue;
    checked.push_back(one);
    largest2 = std::max(largest2, one.squared);
  }
  const std::vector<Bin> bins = binned(checked);
  const double largest = std::sqrt(largest2);
  const Radii radii{largest, gross_radius_of(bins, largest, core2)};
  const Best mixed = best_of(bins, radii, core2, kFirstShare), pure = best_of(bins, radii, core2, 0);
  const bool any_gross = is_better(mixed.fit.log_likelihood, pure.fit.log_likelihood);
  const Best& best = any_gross ? mixed : pure;
  const Fit normal = fit_for(bins, kInfinite, radii, {core2, any_gross ? kFirstShare : 0}, kFine);
  const bool is_student = best.inverse > 0 && is_better(best.fit.log_likelihood, normal.log_likelihood);
  const Fit& fit = is_student ? best.fit : normal;
  ErrorDistribution found{.scale = std::sqrt(fit.scale2),
                          .gross_share = fit.share,
                          .gross_radius = radii.gross,
                          .largest = largest,
                          .directions = coordinates < 1.5 * count ? 1 : 2};
  if (is_student) found.degrees_of_freedom = 1 / best.inverse;
  constexpr double kChance = 3;
  if (!is_student && std::abs(found.scale - 1) < kChance / std::sqrt(2 * coordinates)) found.scale = 1;
  return found;
}

}  // namespace collinea
