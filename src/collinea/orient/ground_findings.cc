// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/ground_findings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "collinea/block/ground_words.h"

namespace collinea {

std::vector<std::string> ground_findings(const Block& setup, const Adjusted& adjusted,
                                         const std::set<std::size_t>& excluded) {
  constexpr double kBeyond = 4;  // standard deviations of the difference: one of 16,000
  constexpr double kDegrees = 180 / std::numbers::pi;
  std::vector<const GroundDifference*> beyond;
  const auto by_sigma = [](const GroundDifference& one) { return std::abs(one.difference) / one.difference_sigma; };
  for (const GroundDifference& one : adjusted.ground)
    if (by_sigma(one) > kBeyond && !excluded.contains(one.observation)) beyond.push_back(&one);
  std::sort(beyond.begin(), beyond.end(), [&](auto* a, auto* b) { return by_sigma(*a) > by_sigma(*b); });
  std::vector<std::string> findings;
  for (const GroundDifference* one : beyond) {
    const GroundObservation& measured = setup.ground[one->observation];
    findings.push_back(fmt::format("{}{} differs from the adjusted block by {:.3g} {}, {:.0f} times what is expected",
                                   measured.is_of_shape() ? "point " : "the ", words_of(measured, setup),
                                   measured.is_angle() ? one->difference * kDegrees : one->difference,
                                   measured.is_angle() ? "degrees" : "m", by_sigma(*one)));
  }
  return findings;
}

}  // namespace collinea
