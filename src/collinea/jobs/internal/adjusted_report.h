// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/jobs/internal/adjust_project_options.h"
#include "collinea/report/adjustment_report.h"

namespace collinea {

/// Adjusts as asked for - data snooping first, then variance components - and says what the user should know. The title
/// is left to the caller. Errors: those of adjust().
[[nodiscard]] Result<AdjustmentReport> adjusted_report(Block block, const AdjustScope& scope,
                                                       const ExamineOptions& options, const AdjustProjectOptions& asked,
                                                       const Run& run);

}  // namespace collinea
