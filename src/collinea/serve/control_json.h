// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "collinea/base/result.h"
#include "collinea/serve/project_views.h"

// JSON of what is known of the images, the ground and the control of a project. Positions are [easting, northing,
// height] m in the map, or in the world where the block has no location on Earth; null: not known. Sigmas hold sigma0.
namespace collinea {

/// {"crs", "crs_name", "proj4", "unit", "bounds": [e0, n0, e1, n1]}.
[[nodiscard]] Result<std::string> map_json(const ProjectView& view);

/// {"tile_px", "images": [{"id", "file", "width", "height", "levels", "camera", "oriented", "position", "sigma_m",
/// "footprint": [[e, n], ..], "marks"}]}: footprints on the plane at the median height of the tie points of an image.
[[nodiscard]] Result<std::string> images_json(const ProjectView& view);

/// {"points": [[x, y, rx, ry], ..]}: residuals, observed minus computed, of at most kMostResiduals tie points of an
/// oriented image, evenly chosen [px].
[[nodiscard]] Result<std::string> residuals_json(const ProjectView& view, ImageId image);
inline constexpr std::size_t kMostResiduals = 5000;

/// {"points": [[e, n, h, se, sn, sh, cen], ..]}: at most so many tie points, evenly chosen; cen: covariance of easting
/// and northing [m^2].
[[nodiscard]] Result<std::string> ties_json(const ProjectView& view, std::size_t most);
inline constexpr std::size_t kMostTies = 100'000;

/// {"points": [{"name", "role", "position", "sigma_m", "adjusted", "difference_m", "difference_sigma_m", "marks":
/// [{"image", "file", "pixel", "sigma_px", "residual_px", "w", "redundancy", "detectable_px"}]}], "sigma0"}. The tests
/// of a mark are those of the adjustment: of its two coordinates the w that is larger in size, the redundancy that is
/// smaller and the minimal detectable bias that is larger. They are null of marks made or moved since.
[[nodiscard]] std::string control_json(const ProjectView& view);

/// The same of the whole block with all marks as they are now (ProjectView::adjusted_with_marks): seconds the first
/// time. Errors: those of it.
[[nodiscard]] Result<std::string> control_now_json(const ProjectView& view);

/// {"next": {"point", "image", "file", "pixel", "placed": [before, after], "rms_sigma_m": [before, after]} or null}:
/// the mark that would help all control points most, of those that are best for each of them (best_next_mark). Errors:
/// kIllPosed, the block is not oriented yet; those of ProjectView::adjusted_with_marks.
[[nodiscard]] Result<std::string> next_mark_json(const ProjectView& view);

/// {"places": [{"image", "file", "pixel", "ellipse": {"major_px", "minor_px", "angle_deg"}, "marked",
/// "sigma_after_m"}], "given_disagrees", "marked": {"position", "sigma_m", "difference_m", "difference_sigma_m",
/// "sigma0", "redundancy", "marks": [{"image", "residual_px", "redundancy", "w", "detectable_px"}]}}: see
/// predicted_marks(). Errors: kNotFound, no point of this name; kIllPosed, the block is not oriented yet.
[[nodiscard]] Result<std::string> predicted_marks_json(const ProjectView& view, const std::string& name);

/// {"pixel", "covariance_px2": [xx, xy, yy], "sigma_px", "kind"}: the target that {"image", "pixel", "kind"} asks for.
/// Errors: kBadInput; kNotFound, no such image; kNotConverged, there is no target.
[[nodiscard]] Result<std::string> refined_json(const ProjectView& view, std::string_view body);

/// {"tags": [{"family", "number", "pixel", "sigma_px"}]}: coded tags of an image (find_tags()), but for those that it
/// shows twice. Cost: a second for 20 million pixels. Errors: the image's.
[[nodiscard]] Result<std::string> tags_json(const ProjectView& view, ImageId image);

}  // namespace collinea
