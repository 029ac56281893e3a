// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "collinea/base/finding.h"
#include "collinea/report/models_report.h"

namespace collinea {

/// What a user should know of models that were joined: those left out and pairs that make none, those tied by few
/// points or by points near a line, those that nothing checks, residuals that contradict the standard deviations, the
/// control point that contradicts most and check points that do.
[[nodiscard]] std::vector<Finding> model_findings(const ModelsReport& report);

}  // namespace collinea
