// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <limits>
#include <set>
#include <vector>

#include "collinea/quality/internal/measurement.h"
#include "collinea/quality/internal/rejected.h"
#include "collinea/quality/internal/suspect_choice.h"

namespace collinea {

/// A rejected measurement, with what it takes to compare it with what is left and to put it back.
struct Rejection {
  Rejected rejected;  ///< as it is reported
  GivenMeasurement given;
  double sigma = 0;  ///< as given, of Rejected::axis [px, m, rad]
  /// Variance of what the others predict, for sigma0 = 1, in sigma^2; NaN: not known.
  double cofactor = std::numeric_limits<double>::quiet_NaN();
};

/// What is left of the measurements, and what has been rejected.
struct Remaining {
  Measurements measurements;
  std::vector<Rejection> rejections;  ///< in the order in which it went
};

/// What is left when a choice has been rejected too. `sigma0`: by which the tests scaled what the others predict;
/// `round`: adjustments so far.
[[nodiscard]] Remaining reject(Remaining remaining, const SuspectChoice& choice, double sigma0, int round);

/// Indices in Remaining::rejections of what agrees with the adjustment without it: its gross error is within `limit`
/// standard deviations. Another gross error, which is gone now, had spoilt it. Not of points of which less than two
/// rays are left, and not of pairs, of which nobody knows which was wrong. What is in `tried` has been put back once;
/// it was suspect again and is gone for good.
[[nodiscard]] std::vector<std::size_t> agreeing(const Remaining& remaining, double limit,
                                                const std::set<Measurement>& tried);

/// Puts measurements back as they were given, by ascending indices in Remaining::rejections.
[[nodiscard]] Remaining put_back(Remaining remaining, const std::vector<std::size_t>& indices);

}  // namespace collinea
