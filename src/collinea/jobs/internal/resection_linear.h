// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/base/result.h"
#include "collinea/jobs/internal/resection_tables.h"
#include "collinea/report/resection_report.h"

namespace collinea {

/// The pose of one image of a known camera by linear equations (LinearPose), ground points taken as exact. Errors:
/// several images, no principal distance, points that leave the pose open.
[[nodiscard]] Result<ResectionReport> by_linear_pose(ResectionTables& tables, const ResectOneOptions& options);

}  // namespace collinea
