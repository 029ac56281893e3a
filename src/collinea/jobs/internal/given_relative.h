// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "collinea/base/result.h"
#include "collinea/jobs/internal/relative_options.h"
#include "collinea/report/relative_report.h"

namespace collinea {

/// The orientation that the options give, in its forms and with its covariance, and the coplanarity of the points of a
/// table for it; `measurements` may be empty. Errors: tables, elements that are none, options of a solution.
[[nodiscard]] Result<RelativeReport> compare_with_given(const std::filesystem::path& measurements,
                                                        const RelativePairOptions& options);

}  // namespace collinea
