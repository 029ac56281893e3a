// SPDX-License-Identifier: Apache-2.0
#pragma once

// How the tests of this module examine their small blocks.

#include <string>
#include <utility>

#include "collinea/adjust/test_block.h"
#include "collinea/quality/examine.h"

namespace collinea::testing {

/// Least squares without any loss, to the last step, with covariances.
inline ExamineOptions examined(std::string calibration = "none") { return {.adjust = plain(std::move(calibration))}; }

/// The same with all tests of the observations.
inline ExamineOptions tested(std::string calibration = "none") {
  ExamineOptions options = examined(std::move(calibration));
  options.reliability = true;
  return options;
}

}  // namespace collinea::testing
