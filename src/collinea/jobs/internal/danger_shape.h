// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "collinea/base/result.h"
#include "collinea/jobs/internal/resection_options.h"
#include "collinea/report/resection_report.h"

namespace collinea {

/// The danger cylinder of an image by its control and its projection centre.
void set_danger_cylinder(std::vector<ResectionReport::Image::Control> control, const Eigen::Vector3d& centre,
                         ResectionReport::Image& image);

/// What there is to say of a resection that has no solution: where control and station lie on the danger circle, that
/// behind the error, and the picture in the folder of the options. `report` holds what is known of its images.
[[nodiscard]] Error with_danger(Error error, const ResectionReport& report, const ResectOneOptions& options);

}  // namespace collinea
