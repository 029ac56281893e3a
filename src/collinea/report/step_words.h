// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "collinea/store/step_records.h"

namespace collinea {

/// What came of a step, on one line.
[[nodiscard]] std::string summary_of(const StepOutcome& outcome);

}  // namespace collinea
