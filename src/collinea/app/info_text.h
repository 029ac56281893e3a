// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "collinea/jobs/info.h"

namespace collinea {

/// What is known of a project, as a JSON object, indented for people to read: images, cameras, crs, oriented,
/// tie_points, observations, mean_reprojection_px, gsd_m, control_rmse_m and check_rmse_m (east, north, height; null
/// where there is none), control_points (name, role, images, difference_m, sigma_m, beyond_3_sigma each), steps (name,
/// seconds, cpu_seconds, peak_memory_bytes, figures each) and the other figures of the orientation.
[[nodiscard]] std::string info_json(const ProjectInfo& info);

/// The same as a short text.
[[nodiscard]] std::string info_text(const ProjectInfo& info);

}  // namespace collinea
