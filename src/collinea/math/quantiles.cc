// SPDX-License-Identifier: Apache-2.0
#include "collinea/math/quantiles.h"

#include <cmath>
#include <numbers>

#include "collinea/base/result.h"

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

double power_of_test(double shift, double limit) {
  const auto below = [](double x) { return std::erfc(-x / std::numbers::sqrt2) / 2; };
  return below(shift - limit) + below(-shift - limit);
}

}  // namespace collinea
