// SPDX-License-Identifier: Apache-2.0
#include "collinea/math/series_tests.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "collinea/math/normal.h"
#include "collinea/math/quantiles.h"

namespace collinea {
namespace {

constexpr long kExactPairs = 1000;  // beyond, the normal distribution is that of the binomial to what matters

// Probability of at most k of n events of probability 1/2.
double half_binomial(long k, long n) {
  if (k >= n) return 1;
  if (k < 0) return 0;
  if (n <= kExactPairs) return incomplete_beta(double(n - k), double(k) + 1, 0.5);
  const double z = (double(k) + 0.5 - double(n) / 2) / std::sqrt(double(n) / 4);
  return normal_probability(z);
}

}  // namespace

double SignChanges::few_p_value() const { return pairs > 0 ? half_binomial(changes, pairs) : 1; }

double SignChanges::p_value() const {
  if (pairs == 0) return 1;
  return std::min(1.0, 2 * half_binomial(std::min(changes, pairs - changes), pairs));
}

double SignChanges::correlation() const {
  return pairs > 0 ? std::cos(std::numbers::pi * double(changes) / double(pairs)) : 0;
}

SignChanges& SignChanges::operator+=(const SignChanges& other) {
  changes += other.changes;
  pairs += other.pairs;
  return *this;
}

SignChanges sign_changes(std::span<const double> series) {
  SignChanges found;
  for (std::size_t i = 0; i + 1 < series.size(); ++i) {
    if (std::isnan(series[i]) || std::isnan(series[i + 1])) continue;
    ++found.pairs;
    found.changes += std::signbit(series[i]) != std::signbit(series[i + 1]);
  }
  return found;
}

double LagOne::p_value() const {
  if (pairs == 0) return 1;
  const double n = double(count), variance = double(pairs) / (n * (n + 2));
  const double a = (1 / variance - 1) / 2;  // (r + 1) / 2 with the beta distribution of a and a
  return std::min(1.0, 2 * incomplete_beta(a, a, (1 - std::abs(correlation)) / 2));
}

LagOne lag_one(std::span<const double> series) {
  LagOne found;
  double squares = 0, products = 0;
  for (std::size_t i = 0; i < series.size(); ++i) {
    if (std::isnan(series[i])) continue;
    ++found.count;
    squares += series[i] * series[i];
    if (i == 0 || std::isnan(series[i - 1])) continue;
    ++found.pairs;
    products += series[i] * series[i - 1];
  }
  if (!(squares > 0)) return {};
  found.correlation = products / squares;
  return found;
}

double Kolmogorov::p_value() const {
  if (count == 0) return 1;
  const double root = std::sqrt(double(count)), x = distance * (root + 0.12 + 0.11 / root);
  if (x < 0.3) return 1;
  double sum = 0;
  for (int k = 1; k <= 100; ++k) {
    const double term = std::exp(-2.0 * k * k * x * x);
    sum += k % 2 ? term : -term;
    if (term < 1e-16 * sum) break;
  }
  return std::clamp(2 * sum, 0.0, 1.0);
}

Kolmogorov kolmogorov(std::vector<double> probabilities) {
  std::erase_if(probabilities, [](double p) { return std::isnan(p); });
  std::ranges::sort(probabilities);
  Kolmogorov found{.count = long(probabilities.size())};
  const double n = double(found.count);
  for (std::size_t i = 0; i < probabilities.size(); ++i) {
    const double below = double(i) / n, with = double(i + 1) / n;
    found.distance = std::max({found.distance, probabilities[i] - below, with - probabilities[i]});
  }
  return found;
}

std::vector<double> holm(std::span<const double> p_values) {
  std::vector<std::size_t> order(p_values.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return p_values[i]; });
  std::vector<double> corrected(p_values.size());
  double largest = 0;  // the smallest of m by m, the next by m - 1 ...
  for (std::size_t k = 0; k < order.size(); ++k) {
    largest = std::max(largest, std::min(1.0, p_values[order[k]] * double(order.size() - k)));
    corrected[order[k]] = largest;
  }
  return corrected;
}

}  // namespace collinea
