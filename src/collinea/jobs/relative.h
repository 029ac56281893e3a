// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "collinea/base/result.h"
#include "collinea/jobs/internal/relative_options.h"
#include "collinea/report/relative_report.h"

namespace collinea {

/// The relative orientation of the pair of images in a table: point x_left y_left x_right y_right, and sigma where it
/// is known (coordinates in px with y down, or in mm or um with y up). Errors: file, columns, no principal distance,
/// points that determine no orientation. With an orientation that is given nothing is solved; without `measurements` it
/// is converted alone.
[[nodiscard]] Result<RelativeReport> orient_pair(const std::filesystem::path& measurements,
                                                 const RelativePairOptions& options);

}  // namespace collinea
