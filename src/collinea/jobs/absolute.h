// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "collinea/base/result.h"
#include "collinea/jobs/internal/absolute_options.h"
#include "collinea/report/absolute_report.h"

namespace collinea {

/// Orients a model (table with point, U, V, W) on the ground (table with point, X, Y, Z) by the points that both have,
/// and brings all points of the model there. Errors: tables, options, control that is not enough.
[[nodiscard]] Result<AbsoluteReport> orient_absolutely(const std::filesystem::path& model,
                                                       const std::filesystem::path& ground,
                                                       const OrientAbsoluteOptions& options);

}  // namespace collinea
