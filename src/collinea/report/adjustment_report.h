// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "collinea/base/result.h"
#include "collinea/quality/additional_choice.h"
#include "collinea/quality/mismatches.h"
#include "collinea/quality/snooping.h"
#include "collinea/quality/variance_components.h"

namespace collinea {

/// All that the report of an adjustment tells.
struct AdjustmentReport {
  std::string title;
  Block block;                                   ///< as adjusted, with the sigmas that were used
  Examined adjusted;                             ///< with covariances and reliability
  std::optional<VarianceComponents> components;  ///< when they were estimated and applied
  std::vector<AdditionalTest> additional;        ///< of cameras with additional parameters
  double additional_level = 0;                   ///< of their tests
  std::optional<Mismatches> mismatches;          ///< of tie points, when they were rejected
  std::optional<Snooped> snooped;  ///< when gross errors were rejected; its `adjusted` may have been moved
};

// Its parts.

/// By what the sigmas of a group should be multiplied; NaN where too little redundancy tells nothing.
[[nodiscard]] double shown_factor(const GroupSums& sums);
/// Names of the additional parameters that the proposal drops: "a3,a7".
[[nodiscard]] std::string dropped_names(const AdditionalTest& test);
/// What was measured, in words: "tie point 17 in IMG_2.jpg, row", "gcp3, height", "position of IMG_2.jpg, east".
[[nodiscard]] std::string name_of(const TestedObservation& observation, const Block& block);
/// A measurement that was rejected, and how wrong it was: "gcp4 in IMG_31.jpg, off by 12.3 px (row ...)".
[[nodiscard]] std::string words_of_rejected(const Rejected& rejected, const Block& block);
/// px in images, m on the ground, deg; and the observation with its figures in that.
[[nodiscard]] const char* unit_of(const TestedObservation& observation);
[[nodiscard]] TestedObservation in_unit(TestedObservation observation);

/// Unknowns beside those of images, cameras and points, without those of shapes, whose numbers tell nobody anything.
[[nodiscard]] std::vector<EstimatedUnknown> shown_unknowns(const Adjusted& adjusted);
/// They are reported in m, m/s (where times are known), s and deg.
[[nodiscard]] const char* unit_of(UnknownKind kind);
[[nodiscard]] double in_unit(UnknownKind kind, double value);

}  // namespace collinea
