// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "collinea/marking/predicted_marks.h"
#include "collinea/marking/refined_mark.h"

namespace collinea {

/// Where images show a control point.
struct MarksReport {
  ControlPoint point;  ///< as it is given
  Block block;
  PredictedMarks marks;
};

/// A table with a line for each image, best first, and what the marks so far say of the point.
[[nodiscard]] std::string predicted_marks_text(const MarksReport& report);

/// "column 12.34 px, row 56.78 px, standard deviations ...": the centre of a target.
[[nodiscard]] std::string refined_mark_text(const RefinedMark& mark);

}  // namespace collinea
