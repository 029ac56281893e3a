// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/jobs/internal/absolute_tables.h"
#include "collinea/report/absolute_report.h"

namespace collinea {

/// The similarity of the plane, X and Y alone. Errors: fewer than two points apart, sigmas that are not above 0.
[[nodiscard]] Result<AbsoluteReport> orient_in_plane(AbsoluteTables& control, const OrientAbsoluteOptions& options);

}  // namespace collinea
