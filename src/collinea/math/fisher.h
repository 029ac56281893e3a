// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace collinea {

/// The chance that Fisher's F with `m` and `r` degrees of freedom exceeds a value. An infinite `r` is the chi-squared
/// distribution of m F.
[[nodiscard]] double fisher_tail(double value, double m, double r);

/// Its natural logarithm, also where the chance is too small for a number.
[[nodiscard]] double log_fisher_tail(double value, double m, double r);

/// The chance that Student's t with `r` degrees of freedom exceeds a value in absolute terms.
[[nodiscard]] inline double student_tail(double value, double r) { return fisher_tail(value * value, 1, r); }

}  // namespace collinea
