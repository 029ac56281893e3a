// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "collinea/base/result.h"
#include "collinea/restitution/stereo_view.h"
#include "collinea/serve/project_views.h"

// JSON of the stereoplotter. Parallax: column left less column right, in pixels of the epipolar images.
namespace collinea {

/// {"images", "files", "focal_px", "base_m", "left_from_world": {"rotation" (by rows), "translation"}, "left", "right":
/// {"image", "file", "width", "height", "levels", "columns", "rows", "cx", "cy", "lattice": {"step_px", "columns",
/// "rows", "error_px", "nodes": [x, y, ..]}}, "map": {"origin", "scale_m", "coefficients"}, "mark": [x, y, parallax],
/// "position", "covariance_m2", "sigma_m", "base_to_height", "convergence_rad", "sigma_height_m", "pairs": [{"images",
/// "files", "base_to_height", "convergence_rad", "gsd_m", "sigma_height_m", "hidden"}]}: see StereoView. Errors:
/// those of stereo_view().
[[nodiscard]] Result<std::string> stereo_json(const ProjectView& view, const AskedStereo& asked);

/// {"mark", "sigma_px", "mark_sigma_px", "correlation", "position", "covariance_m2", "sigma_m", "pixels"}: the mark of
/// {"images": [l, r], "mark": [x, y, parallax], "search_px", "window_px"} set on the ground (match_ground()). Errors:
/// kBadInput; those of match_ground().
[[nodiscard]] Result<std::string> ground_json(const ProjectView& view, std::string_view body);

}  // namespace collinea
