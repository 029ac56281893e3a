// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "collinea/base/finding.h"
#include "collinea/jobs/internal/resection_options.h"
#include "collinea/report/interior_report.h"
#include "collinea/report/intersection_report.h"
#include "collinea/report/resection_report.h"

namespace collinea {

// What a user should know of orientations of single images and of points met by their rays. Reports are complete but
// for their findings.

/// Poses that three points leave open, control that hardly determines a pose or lies on the danger circle, measurements
/// that contradict or were rejected, residuals against stated sigmas.
[[nodiscard]] std::vector<Finding> resection_findings(const ResectionReport& report, const ResectOneOptions& options);

/// Images whose control lies on a circle, with the station near it or near the cylinder over it.
[[nodiscard]] std::vector<Finding> danger_findings(const ResectionReport& report);

/// Points of one image, rays that do not meet or meet at small angles, orientations without sigmas, residuals against
/// stated sigmas.
[[nodiscard]] std::vector<Finding> intersection_findings(const IntersectionReport& report);

/// Marks that contradict, were left out, are missing or unknown, readings that differ, films from behind.
[[nodiscard]] std::vector<Finding> interior_findings(const InteriorReport& report);

}  // namespace collinea
