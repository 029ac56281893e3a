// SPDX-License-Identifier: Apache-2.0
#include "collinea/math/fisher.h"

#include <cmath>
#include <limits>

#include "collinea/base/result.h"

namespace collinea {
namespace {

constexpr double kTiny = 1e-300, kSmallest = 1e-15;
constexpr int kMostTerms = 10000;

// The continued fraction of the incomplete beta function (Abramowitz and Stegun 26.5.8), by the method of Lentz; it
// converges for x < (a + 1) / (a + b + 2).
double beta_fraction(double a, double b, double x) {
  const auto away_from_zero = [](double value) { return std::abs(value) < kTiny ? kTiny : value; };
  double c = 1, d = 1 / away_from_zero(1 - (a + b) * x / (a + 1)), value = d;
  for (int m = 1; m < kMostTerms; ++m) {
    const double even = m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m));
    d = 1 / away_from_zero(1 + even * d);
    c = away_from_zero(1 + even / c);
    value *= d * c;
    const double odd = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1));
    d = 1 / away_from_zero(1 + odd * d);
    c = away_from_zero(1 + odd / c);
    value *= d * c;
    if (std::abs(d * c - 1) < kSmallest) break;
  }
  return value;
}

// A chance, as the exponential of `log` times `factor`: what is too small for a number keeps its logarithm.
struct Chance {
  double log = 0, factor = 1;

  [[nodiscard]] double value() const { return std::exp(log) * factor; }
  [[nodiscard]] double logarithm() const { return log + std::log(factor); }
};

// The regularised incomplete beta function I_x(a, b).
Chance incomplete_beta(double a, double b, double x) {
  if (!(x > 0)) return {0, 0};
  if (!(x < 1)) return {};
  const double front = std::lgamma(a + b) - std::lgamma(a) - std::lgamma(b) + a * std::log(x) + b * std::log1p(-x);
  if (x < (a + 1) / (a + b + 2)) return {front, beta_fraction(a, b, x) / a};
  return {0, 1 - std::exp(front) * beta_fraction(b, a, 1 - x) / b};
}

// Upper tail of the chi-squared distribution: the regularised incomplete gamma function Q(m/2, value/2).
Chance chi_squared_tail(double value, double m) {
  const double a = m / 2, x = value / 2;
  const double front = a * std::log(x) - x - std::lgamma(a);
  if (x < a + 1) {  // series of P
    double term = 1 / a, sum = term;
    for (int n = 1; n < kMostTerms && term > kSmallest * sum; ++n) sum += term *= x / (a + n);
    return {0, 1 - std::exp(front) * sum};
  }
  double b = x + 1 - a, c = 1 / kTiny, d = 1 / b, fraction = d;
  for (int n = 1; n < kMostTerms; ++n) {
    const double part = -n * (n - a);
    b += 2;
    d = 1 / (part * d + b);
    c = b + part / c;
    fraction *= d * c;
    if (std::abs(d * c - 1) < kSmallest) break;
  }
  return {front, fraction};
}

Chance tail(double value, double m, double r) {
  COLLINEA_CHECK(m > 0 && r > 0);
  if (!(value > 0)) return {0, std::isnan(value) ? value : 1};
  if (std::isinf(r)) return chi_squared_tail(m * value, m);
  return incomplete_beta(r / 2, m / 2, r / (r + m * value));
}

}  // namespace

double fisher_tail(double value, double m, double r) { return tail(value, m, r).value(); }

double log_fisher_tail(double value, double m, double r) { return tail(value, m, r).logarithm(); }

}  // namespace collinea
