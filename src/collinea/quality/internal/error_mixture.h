// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <optional>
#include <span>

namespace collinea {

/// The error of an image point in units of the standard deviation that it should have: the residual without the part
/// that the adjustment took of it. Its squared length is v' (sigma^2 R)^+ v with the 2 x 2 block R of redundancy
/// numbers, chi-squared for normal errors, over those directions that something checks: of a point with two rays one.
struct CheckedError {
  double squared = 0;
  int directions = 0;  ///< 1 or 2; 0: nothing checks it
};

/// What errors are distributed like: a part `gross_share` is gross, alike anywhere up to `gross_radius`; the others
/// have Student's distribution in one or two dimensions, cut off at `largest`. Longer errors are rejected before an
/// adjustment, as by orientation, which makes tails shorter than those of the distribution that shows in all the rest.
struct ErrorDistribution {
  double scale = 1;  ///< of Student's distribution, in standard deviations as given: that of its core
  double degrees_of_freedom = std::numeric_limits<double>::infinity();  ///< infinite: the errors are normal
  double gross_share = 0, gross_radius = 0;
  double largest = std::numeric_limits<double>::infinity();
  int directions = 2;  ///< of most of the errors

  [[nodiscard]] bool is_normal() const { return degrees_of_freedom == std::numeric_limits<double>::infinity(); }
  /// Probability that an error is a gross one; 1 of those beyond `largest`.
  [[nodiscard]] double gross_probability(const CheckedError& error) const;
  /// What a coordinate of an error that is not gross exceeds with probability `alpha`, on either side.
  [[nodiscard]] double limit(double alpha) const;
};

/// The distribution of given errors by maximum likelihood: expectation and maximisation (Dempster, Laird, Rubin 1977)
/// of scale and gross share for each of some degrees of freedom (Lange, Little, Taylor 1989), then the best of these,
/// between 1 and infinity. What is cut off counts as missing. The simpler wins unless the other is better beyond chance
/// (0.1 %): no gross errors, normal ones. Where the scale of normal errors is 1 to chance it is 1. Nothing with fewer
/// than 200 errors, or when most of them are zero.
///
/// Cost: linear in the errors, once; everything else works on some hundred classes of size.
[[nodiscard]] std::optional<ErrorDistribution> fit_errors(std::span<const CheckedError> errors);

}  // namespace collinea
