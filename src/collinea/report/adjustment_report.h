// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/orient/adjustment.h"

namespace collinea {

/// All that the report of an adjustment tells.
struct AdjustmentReport : Adjustment {
  std::string title;
  SpellOption spelling = {};  ///< of options on the page and in notes; nothing: "option name = value"
};

/// What the user should know of it at once, sentence by sentence: what was corrected and rejected, what is weak.
[[nodiscard]] std::vector<std::string> notes_of(const AdjustmentReport& report);

// Its parts.

/// The points that were chosen for the datum, control points first: "gcp1", "tie point 17".
[[nodiscard]] std::vector<std::string> datum_point_names(const AdjustmentReport& report);
/// The same as a sentence, and that they have no effect where the datum is fixed; empty: none were chosen.
[[nodiscard]] std::string datum_points_words(const AdjustmentReport& report);
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
