// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string_view>

#include "collinea/base/result.h"
#include "collinea/io/adjustment_file.h"

namespace collinea {

/// Image coordinates and control as the bundle adjustment PATB reads them (and MATCH-AT, ORIMA, Metashape and others
/// write them). NAME.im: for each image a line with its number and its focal length, then number, x and y of each point
/// (and a group of standard deviations, which is passed over), closed by -99; micrometres from the principal point, x
/// right and y up, free of distortion, which PATB does not know. NAME.con: number, X and Y of horizontal control, -99,
/// number and Z of vertical control, -99; a point may be in both.
///
/// The format has no place for names, standard deviations and the size of a pixel: they are in NAME.names beside it
/// (see internal/photo_points.h), where we wrote it.

/// Writes NAME.im, NAME.con and NAME.names for the oriented images: `path` is that of NAME.im. `pixel_um`: what is
/// taken for the size of a pixel; PATB looks at ratios to the focal length alone. Errors: a fisheye, disk, names with
/// control characters.
[[nodiscard]] Result<> write_patb(const std::filesystem::path& path, const Block& block, double pixel_um);

/// Reads NAME.im and, where they are there, NAME.con and NAME.names. Cameras of different focal lengths are different
/// cameras. Without NAME.names image coordinates have 3 um, control 0.05 m, and a pixel is 1 um. Errors name the file
/// and the line.
[[nodiscard]] Result<AdjustmentFile> read_patb(const std::filesystem::path& path);

/// Whether the text looks like a NAME.im: two numbers above 0, then a point with two coordinates, and -99 further on.
[[nodiscard]] bool is_patb(std::string_view text);

}  // namespace collinea
