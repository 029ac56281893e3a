// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "collinea/base/file_text.h"
#include "collinea/base/result.h"
#include "collinea/io/control_contents.h"

namespace collinea {

/// Titles of the columns of our CSV, for those who write one; the reader does not need them.
inline constexpr FileText kControlPointColumns =
    "point, id, easting, northing, height, sigma_e_m, sigma_n_m, sigma_h_m, role";
inline constexpr FileText kControlImageColumns = "image, id, file, x_px, y_px, sigma_px";
inline constexpr FileText kImageCovarianceColumns = "image_covariance, id, file, xx_px2, xy_px2, yy_px2";

/// Reads surveyed points and where they are seen in images, in one of the formats of `internal/control_formats.h`,
/// recognised by content: OpenDroneMap's gcp_list.txt, our CSV. In files in degrees (EPSG:4326) x is the longitude and
/// y the latitude; they come back in the UTM zone of their first point, heights unchanged.
///
/// Pixels count from the outer corner of the image, as ours do. UTF-8 or UTF-16. Errors name the line.
[[nodiscard]] Result<ControlFile> read_control(const std::filesystem::path& path, const ControlDefaults& defaults = {});

/// The same, from text in memory.
[[nodiscard]] Result<ControlFile> parse_control(std::string_view text, const ControlDefaults& defaults = {});

/// Makes the named points check points, and all others control points. Errors: there is no point of such a name.
[[nodiscard]] Result<> set_check_points(ControlFile& control, std::span<const std::string> names);

/// The CRS that a line of an OpenDroneMap file means, as PROJ understands it; empty when it is not a CRS.
[[nodiscard]] std::string normalised_crs(std::string_view text);

}  // namespace collinea
