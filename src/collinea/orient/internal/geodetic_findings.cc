// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/internal/geodetic_findings.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace collinea {

std::vector<Finding> geodetic_findings(const Block& setup, const Adjusted& adjusted,
                                       const std::set<std::size_t>& excluded) {
  constexpr double kBeyond = 4;  // standard deviations of the difference: one of 16,000
  constexpr double kDegrees = 180 / std::numbers::pi;
  std::vector<const GeodeticDifference*> beyond;
  const auto by_sigma = [](const GeodeticDifference& one) { return std::abs(one.difference) / one.difference_sigma; };
  for (const GeodeticDifference& one : adjusted.geodetic)
    if (by_sigma(one) > kBeyond && !excluded.contains(one.observation)) beyond.push_back(&one);
  std::sort(beyond.begin(), beyond.end(), [&](auto* a, auto* b) { return by_sigma(*a) > by_sigma(*b); });
  std::vector<Finding> findings;
  for (const GeodeticDifference* one : beyond) {
    const GeodeticObservation& measured = setup.geodetic[one->observation];
    const bool angle = measured.is_angle();
    findings.push_back(finding_of(angle ? FindingCode::kGeodeticAngleDiffers : FindingCode::kGeodeticDiffers,
                                  {Subject::geodetic(one->observation)},
                                  {{angle ? FigureName::kDifferenceAngle : FigureName::kDifference,
                                    angle ? one->difference * kDegrees : one->difference},
                                   {FigureName::kRatio, by_sigma(*one)}}));
  }
  return findings;
}

}  // namespace collinea
