// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "collinea/math/random.h"

// Least median of squares (Rousseeuw 1984; Rousseeuw and Leroy 1987): of the models of samples of p measurements that
// whose h-th smallest error is least.
namespace collinea {

/// h of n errors: half of them and half of a sample more.
[[nodiscard]] constexpr std::size_t median_rank(std::size_t n, std::size_t p) {
  return std::min(n, n / 2 + (p + 1) / 2);
}

/// The standard deviation of one coordinate of an error of `directions` (1 or 2) that the h-th smallest of n errors
/// tells where the others are wrong: over the median of chi-squared, with a correction for few measurements.
[[nodiscard]] inline double robust_sigma(double error_of_rank, std::size_t n, std::size_t p, int directions) {
  const double of_normal = directions == 1 ? 1.4826 : 0.8493;
  return of_normal * (1 + 5 / std::max(1.0, double(n) - double(p))) * error_of_rank;
}

/// Beyond so many of them an error counts as wrong: one of a hundred right ones does.
[[nodiscard]] constexpr double wrong_beyond(int directions) { return directions == 1 ? 2.5 : 3.04; }

/// Calls visit(i, j, k) with all triples below n, or with `most` drawn ones where there are more.
template <class Visit>
void for_triples(std::size_t n, std::size_t most, std::uint64_t seed, const Visit& visit) {
  if (n * (n - 1) * (n - 2) / 6 <= most) {
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = i + 1; j < n; ++j)
        for (std::size_t k = j + 1; k < n; ++k) visit(i, j, k);
    return;
  }
  Random random(seed);
  const auto below = static_cast<std::uint32_t>(n);
  for (std::size_t trial = 0; trial < most; ++trial) {
    const std::size_t i = random.below(below), j = random.below(below), k = random.below(below);
    if (i != j && j != k && i != k) visit(i, j, k);
  }
}

}  // namespace collinea
