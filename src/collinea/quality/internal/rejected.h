// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <map>
#include <span>
#include <vector>

#include "collinea/base/words.h"
#include "collinea/quality/internal/measurement.h"
#include "collinea/quality/internal/reliability.h"

namespace collinea {

/// A measurement that data snooping rejected. Units: px in images, m, rad for angles.
struct Rejected : Measurement {
  int axis = 0;           ///< the coordinate that was beyond the limit: 0 column or east, 1 row or north, 2 height
  double w = 0;           ///< its test when it was the worst; infinite: its image does not see the point
  double limit = 0;       ///< of that test
  double redundancy = 0;  ///< its redundancy number then; NaN: gross, rejected before there was one
  double influence = 0;   ///< by how much the adjusted value of that coordinate followed it
  /// Measured minus what the adjustment without it says, with the standard deviation that this would have without a
  /// gross error; of geodetic observations in the first coordinate. NaN for axes that were not measured or, of the
  /// sigma, not tested.
  Eigen::Vector3d gross_error = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  double sigma = 0;      ///< of gross_error[axis]
  bool as_pair = false;  ///< one of the two rays of a point: which of them was wrong cannot be told, both went
  int round = 0;         ///< adjustments before it went; 0: gross, before the first
};

/// Why a suspect had to stay.
enum class StayReason : std::uint8_t {
  kTooLittleChecks,  ///< too little of a gross error shows in its residual
  kSameDegree,       ///< others are suspect to the same degree
  kBlockNeedsIt,     ///< without it the block is not determined
  kWorseOfItsPoint,  ///< what is more suspect of its point stays
  kImageNeedsIt,     ///< its image would keep too few measurements
};
inline constexpr Word<StayReason> kStayReasonWords[] = {{StayReason::kTooLittleChecks, "too_little_checks"},
                                                        {StayReason::kSameDegree, "same_degree"},
                                                        {StayReason::kBlockNeedsIt, "block_needs_it"},
                                                        {StayReason::kWorseOfItsPoint, "worse_of_its_point"},
                                                        {StayReason::kImageNeedsIt, "image_needs_it"}};
constexpr std::span<const Word<StayReason>> words(StayReason) { return kStayReasonWords; }

/// A suspect that had to stay.
struct KeptSuspect {
  TestedObservation observation;  ///< its source refers to the block that was tested
  StayReason reason{};
};

/// Two sets of measurements of which either is wrong, or the other: gross errors in the one look like gross errors in
/// the other.
struct InseparableSets {
  std::vector<Measurement> either, or_else;
};

/// Measurements that stay whatever their tests say, from rounds that had to be taken back.
using StayReasons = std::map<Measurement, StayReason>;

}  // namespace collinea
