// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/base/result.h"
#include "collinea/io/text_table.h"
#include "collinea/jobs/internal/relative_options.h"
#include "collinea/report/relative_report.h"

namespace collinea {

/// Frame, names and points of a table: point x_left y_left x_right y_right, and sigma where it is known. Errors:
/// columns, no principal distance, a sigma that is not above zero.
[[nodiscard]] Result<> read_pair_points(const TextTable& table, const RelativePairOptions& options,
                                        RelativeReport& report);

/// Sets the exterior orientation of the second image in the model, from the orientation and the base of the report.
/// `of_change`: the covariance of [changed(), length of the base].
void set_right_pose(const Eigen::Matrix<double, 6, 6>& of_change, RelativeReport& report);

}  // namespace collinea
