// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "collinea/base/result.h"
#include "collinea/jobs/internal/resection_options.h"
#include "collinea/report/resection_report.h"

namespace collinea {

/// The exterior orientation of the images of a table (image, point, x, y, sigma; image may be missing) by ground points
/// (point, X, Y, Z, sigmas; "-" where not known). Points without ground coordinates that several images see are tie
/// points. Of a station: point, direction. Errors: tables, options, geometry.
[[nodiscard]] Result<ResectionReport> resect_from_tables(const std::filesystem::path& measurements,
                                                         const std::filesystem::path& ground,
                                                         const ResectOneOptions& options);

}  // namespace collinea
