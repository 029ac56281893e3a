// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <string>

#include "collinea/math/quantiles.h"
#include "rows.h"

namespace collinea::bench {

inline constexpr double kMinimalDetectableBias = 4, kLargestGrossError = 20;  ///< [sigmas]
inline constexpr int kMostRejected = 10000;

/// Gross errors planted, and what snooping found of them beside what theory predicts.
struct Counts {
  double planted = 0, found = 0, expected = 0, variance = 0;

  /// `redundancy`: of the observation; `limit`: of the test.
  void plant(double sigmas, double redundancy, double limit) {
    const double shift = std::abs(sigmas) * std::sqrt(redundancy);
    const double power = power_of_test(shift, limit);
    ++planted;
    expected += power;
    variance += power * (1 - power);
  }
  [[nodiscard]] bool ok() const { return std::abs(found - expected) < 4 * std::sqrt(variance) + 0.5; }
  [[nodiscard]] Row row(const std::string& what) const {
    return {
        what, "share that theory says, within 4 binomial deviations",
        fmt::format("{:.0f} of {:.0f} found; expected {:.1f} +- {:.1f}", found, planted, expected, std::sqrt(variance)),
        ok()};
  }
};

}  // namespace collinea::bench
