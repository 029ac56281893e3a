// SPDX-License-Identifier: Apache-2.0
#include "collinea/math/quantiles.h"

#include <cmath>
#include <numbers>

#include "collinea/base/result.h"
#include "collinea/math/normal.h"

namespace collinea {
namespace {

// Where a falling function crosses a value.
template <class Falling>
double crossing(double low, double high, double value, Falling&& falling) {
  for (int halving = 0; halving < 100 && high - low > 1e-14 * high; ++halving) {
    const double middle = (low + high) / 2;
    (falling(middle) > value ? low : high) = middle;
  }
  return (low + high) / 2;
}

// Integral of cos(x)^power from `from` to pi / 2, by Simpson's rule over what is not negligible.
double cosine_tail(double from, double power) {
  constexpr int kPanels = 4000;
  const double to = std::fmin(std::numbers::pi / 2, from + 12 / std::sqrt(power + 1)), h = (to - from) / kPanels;
  double sum = 0;
  for (int i = 0; i <= kPanels; ++i)
    sum += (i == 0 || i == kPanels ? 1 : i % 2 ? 4 : 2) * std::pow(std::fmax(std::cos(from + i * h), 0), power);
  return sum * h / 3;
}

// Incomplete beta function I_x(a, b) by its continued fraction, which converges fast for x < (a + 1) / (a + b + 2)
// (DLMF 8.17.22, by the method of Lentz).
double beta_fraction(double a, double b, double x) {
  constexpr int kMostTerms = 500;
  constexpr double kTiny = 1e-300, kSettled = 1e-14;
  const auto off_zero = [](double value) { return std::abs(value) < kTiny ? kTiny : value; };
  double c = 1, d = 1 / off_zero(1 - (a + b) * x / (a + 1)), product = d;
  for (int m = 1; m <= kMostTerms; ++m) {
    const double even = m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m)),
                 odd = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1));
    for (const double term : {even, odd}) {
      d = 1 / off_zero(1 + term * d);
      c = off_zero(1 + term / c);
      product *= c * d;
    }
    if (std::abs(c * d - 1) < kSettled) break;
  }
  return std::exp(a * std::log(x) + b * std::log1p(-x) + std::lgamma(a + b) - std::lgamma(a) - std::lgamma(b)) *
         product / a;
}

// Probability that |t| exceeds x > 0.
double student_tail(double x, double nu) { return incomplete_beta(nu / 2, 0.5, nu / (nu + x * x)); }

}  // namespace

double normal_limit(double alpha) {
  COLLINEA_CHECK(alpha > 0 && alpha < 1);
  return crossing(0, 40, alpha, [](double x) { return std::erfc(x / std::numbers::sqrt2); });
}

// tau = sqrt(r) sin(x), and x has the density cos(x)^(r - 2).
double tau_limit(double alpha, long redundancy) {
  COLLINEA_CHECK(alpha > 0 && alpha < 1 && redundancy > 0);
  if (redundancy == 1) return 1;
  if (redundancy > 100000) return normal_limit(alpha);  // they differ by less than 1e-4
  const double power = double(redundancy) - 2, all = cosine_tail(0, power);
  const double angle = crossing(0, std::numbers::pi / 2, alpha, [&](double x) { return cosine_tail(x, power) / all; });
  return std::sqrt(double(redundancy)) * std::sin(angle);
}

double incomplete_beta(double a, double b, double x) {
  if (!(x > 0)) return 0;
  if (x >= 1) return 1;
  return x < (a + 1) / (a + b + 2) ? beta_fraction(a, b, x) : 1 - beta_fraction(b, a, 1 - x);
}

double student_limit(double alpha, double degrees_of_freedom) {
  COLLINEA_CHECK(alpha > 0 && alpha < 1 && degrees_of_freedom > 0);
  constexpr double kAsNormal = 1e6;
  if (degrees_of_freedom > kAsNormal) return normal_limit(alpha);
  // By the logarithm: with few degrees of freedom limits are large.
  return std::exp(
      crossing(0, 800, alpha, [&](double x) { return student_tail(std::exp(x - 80), degrees_of_freedom); }) - 80);
}

double power_of_test(double shift, double limit) {
  return normal_probability(shift - limit) + normal_probability(-shift - limit);
}

}  // namespace collinea
