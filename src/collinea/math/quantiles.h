// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace collinea {

/// The two-sided limit of a standard normal variable: exceeded in absolute value with probability `alpha` (0 < alpha <
/// 1).
[[nodiscard]] double normal_limit(double alpha);
/// The same of Pope's tau (1976), a residual divided by its estimated standard deviation, with `redundancy` degrees of
/// freedom in all: sqrt(redundancy) at most, and exactly that for one.
[[nodiscard]] double tau_limit(double alpha, long redundancy);

/// The same of Student's distribution with `degrees_of_freedom` (> 0, infinite: normal) and the scale 1, by the
/// incomplete beta function to a relative 1e-10.
[[nodiscard]] double student_limit(double alpha, double degrees_of_freedom);

/// The regularised incomplete beta function I_x(a, b), 0 <= x <= 1: the probability that a variable with the beta
/// distribution of a, b > 0 is below x.
[[nodiscard]] double incomplete_beta(double a, double b, double x);

/// Probability that a standard normal variable shifted by `shift` is beyond the limit on either side: the power of a
/// test, for a blunder of n sigmas and the redundancy number r by n sqrt(r).
[[nodiscard]] double power_of_test(double shift, double limit);

}  // namespace collinea
