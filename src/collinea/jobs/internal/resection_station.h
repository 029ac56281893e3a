// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/base/result.h"
#include "collinea/jobs/internal/resection_tables.h"
#include "collinea/report/resection_report.h"

namespace collinea {

/// The station of directions in the plane. Errors: several stations, points that leave it open.
[[nodiscard]] Result<ResectionReport> of_station(ResectionTables& tables, const ResectOneOptions& options);

}  // namespace collinea
