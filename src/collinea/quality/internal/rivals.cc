// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/internal/rivals.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

namespace collinea {
namespace {

constexpr double kSame = 0.99;  // of |w|; correlation of the tests of two observations

// Correlation of two tests from what the redundancy number of one becomes without the other: r (1 - rho^2).
double correlation_of_tests(double redundancy, double redundancy_without) {
  return std::sqrt(std::max(0.0, 1 - redundancy_without / redundancy));
}

}  // namespace

Rivals rivals_of(const TestedObservation& worst, const Reliability& tests, const Block& block) {
  Rivals found{.worst = measurement_at({worst.group, worst.source}, block),
               .worst_is_poor = worst.redundancy < kPoorRedundancy};
  for (const TestedObservation& other : tests.suspects) {
    if (is_image_point(other.group)) continue;
    const Measurement its = measurement_at({other.group, other.source}, block);
    const double own = std::abs(worst.suspicion), its_own = std::abs(other.suspicion);
    const bool near = found.worst_is_poor ? own - its_own < tests.limit * std::numbers::sqrt2
                                          : its_own > kSame * own && own > kSame * its_own;
    if (its != found.worst && near) found.rivals[{its, other.axis}] = {other.redundancy, own - its_own};
  }
  return found;
}

StayReasons doubts(const Rivals& rivals, const Reliability& tests_without, const Block& block) {
  if (rivals.rivals.empty()) return {};
  const double limit = tests_without.limit;
  StayReasons stay;
  for (const TestedObservation& one : tests_without.others) {
    const Measurement measurement = measurement_at({one.group, one.source}, block);
    const auto rival = rivals.rivals.find({measurement, one.axis});
    if (rival == rivals.rivals.end()) continue;
    const double correlation = correlation_of_tests(rival->second.redundancy, one.redundancy);
    const bool explained = rivals.worst_is_poor && std::abs(one.w) < limit &&
                           rival->second.behind < limit * std::sqrt(2 * (1 - correlation));
    if (correlation > kSame || explained) stay[measurement] = StayReason::kSameDegree;
  }
  if (stay.empty()) return {};
  if (rivals.worst_is_poor) return {{rivals.worst, StayReason::kTooLittleChecks}};
  stay[rivals.worst] = StayReason::kSameDegree;
  return stay;
}

}  // namespace collinea
