// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "collinea/project/project.h"

namespace collinea {

/// What is known of a project, as a JSON object: images, oriented, tie_points, observations, mean_reprojection_px,
/// gsd_m, control_rmse_m and check_rmse_m (east, north, height; null where there is none), steps (name, seconds,
/// cpu_seconds, peak_memory_bytes each) and what else the orientation told of itself. Indented for people to read.
[[nodiscard]] Result<std::string> info_json(const ProjectStore& store);

/// The same as a short text.
[[nodiscard]] Result<std::string> info_text(const ProjectStore& store);

}  // namespace collinea
