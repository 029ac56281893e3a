// SPDX-License-Identifier: Apache-2.0
#pragma once

// How the tests of this module examine their small blocks.

#include <string>
#include <utility>

#include "collinea/adjust/test_block.h"
#include "collinea/quality/examine.h"

namespace collinea::testing {

/// Least squares without any loss, to the last step, with covariances.
inline ExamineOptions examined(Calibration calibration = Calibration::kNone) { return {.adjust = plain(calibration)}; }

/// The same with all tests of the observations.
inline ExamineOptions tested(Calibration calibration = Calibration::kNone) {
  ExamineOptions options = examined(calibration);
  options.reliability = true;
  return options;
}

}  // namespace collinea::testing
