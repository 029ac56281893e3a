// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "collinea/math/few.h"

namespace collinea {

/// The real roots of c[0] + c[1] x + c[2] x^2, ascending; a double root once. Nothing for a constant.
[[nodiscard]] Few<double, 2> real_roots(const std::array<double, 3>& c);

/// The real roots of c[0] + ... + c[3] x^3 in no order, polished by Newton's method. Roots beyond 1e12 are left out.
[[nodiscard]] Few<double, 3> real_roots(const std::array<double, 4>& c);

/// The real roots of c[0] + ... + c[10] x^10 in no order, each once, isolated by a Sturm chain on the projective line
/// (so that large roots are found as well as small ones) and refined by a bracketed Newton iteration to about 1e-15 of
/// max(1, |root|) where they are simple. Roots beyond 1e8 are left out, roots nearer than 1e-7 may count
/// as one.
[[nodiscard]] Few<double, 10> real_roots(const std::array<double, 11>& c);

}  // namespace collinea
