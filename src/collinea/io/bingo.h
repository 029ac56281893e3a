// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string_view>

#include "collinea/base/result.h"
#include "collinea/io/adjustment_file.h"

namespace collinea {

/// Image coordinates, cameras, control and orientations as the bundle adjustment BINGO reads them (and Metashape,
/// Pix4D and OrthoEngine write them), in one folder:
///   - image.dat: for each image a line with its number and its camera, then number, x and y of each point, closed by
///     -99 (Pix4D: by an empty line); millimetres, x right and y up
///   - geoin.dat: "CAPA camera 0 focal x0 y0" [mm]; "CONT number E N H" control, "CHCK number E N H" check points
///   - itera.dat: "ORIA image X Y Z phi omega kappa 0": approximate orientations [m, gon],
///     ground = Ry(phi) Rx(omega) Rz(kappa) image, image frame x right, y up, z backward
/// Words that we do not know are passed over, and so are lines that begin with * or C. Coordinates that we write are
/// free of distortion and count from the principal point (x0 = y0 = 0); those that we read are taken so.
///
/// Names, standard deviations and the size of a pixel stand in names.dat beside it, where we wrote it.

/// Writes the four files into the folder of `path` (that of image.dat). Errors: a fisheye, disk, names with control
/// characters.
[[nodiscard]] Result<> write_bingo(const std::filesystem::path& path, const Block& block, double pixel_um);

/// Reads image.dat (under any name) and geoin.dat, where there is one itera.dat, and names.dat beside it. Without
/// names.dat image coordinates have 3 um, control 0.05 m, and a pixel is 1 um. Errors name the file and the line: bad
/// lines, a camera that geoin.dat does not have.
[[nodiscard]] Result<AdjustmentFile> read_bingo(const std::filesystem::path& path);

/// Whether the text looks like an image.dat: a head whose camera is no number, then a point. One whose camera is a
/// number is told from PATB by geoin.dat beside it: `has_geoin`.
[[nodiscard]] bool is_bingo(std::string_view text, bool has_geoin);

}  // namespace collinea
