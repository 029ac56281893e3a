// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

namespace collinea {

// Tests of a series of numbers in their order, and of their distribution. All take independent numbers of mean zero:
// residuals are first made independent, or chosen so that they nearly are. NaN stands for a number that is missing; its
// neighbours do not touch.

/// Changes of sign between neighbours (Wald, Wolfowitz 1940; with a known median 0, so that a series that stays on one
/// side shows, too). Of independent numbers each pair changes with probability 1/2, whatever their distribution.
struct SignChanges {
  long changes = 0, pairs = 0;

  [[nodiscard]] long runs() const { return pairs > 0 ? changes + 1 : 0; }
  /// Chance of so few changes or fewer, binomial; 1 without pairs.
  [[nodiscard]] double few_p_value() const;
  /// Twice the smaller chance of so few, so many.
  [[nodiscard]] double p_value() const;
  /// Correlation of neighbours for which normal numbers change so often: cos(pi changes / pairs). 0 without pairs.
  [[nodiscard]] double correlation() const;
  SignChanges& operator+=(const SignChanges& other);
};
[[nodiscard]] SignChanges sign_changes(std::span<const double> series);

/// The correlation of neighbours, sum u_i u_i+1 / sum u_i^2, about the known mean 0. Of independent normal numbers its
/// mean is 0 and its variance pairs / (n (n + 2)), of any n: direction and length of the series are independent. Longer
/// tails make it smaller.
struct LagOne {
  double correlation = 0;
  long count = 0, pairs = 0;
  /// Two-sided, by the symmetric beta distribution on (-1, 1) of that variance; 1 without pairs.
  [[nodiscard]] double p_value() const;
};
[[nodiscard]] LagOne lag_one(std::span<const double> series);

/// The largest distance between the distribution of numbers and the uniform one of probabilities in [0, 1], to which
/// the expected distribution turns them (Kolmogorov 1933).
struct Kolmogorov {
  double distance = 0;
  long count = 0;
  /// Chance of a larger distance, with the correction of Stephens (1970) for small n. Where a scale was estimated from
  /// the same numbers it is up to a quarter too large (simulated).
  [[nodiscard]] double p_value() const;
};
[[nodiscard]] Kolmogorov kolmogorov(std::vector<double> probabilities);

/// P-values corrected for their number, so that the smallest corrected one is below a level with at most that chance
/// when all hypotheses are true, however they depend on each other (Holm 1979).
[[nodiscard]] std::vector<double> holm(std::span<const double> p_values);

}  // namespace collinea
