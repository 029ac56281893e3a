// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/base/result.h"
#include "collinea/jobs/internal/resection_tables.h"
#include "collinea/report/resection_report.h"

namespace collinea {

/// The direct linear transformation of one image, of points in space or of a plane. Errors: several images, points that
/// leave the matrix open.
[[nodiscard]] Result<ResectionReport> by_transformation(ResectionTables& tables, const ResectOneOptions& options);

}  // namespace collinea
