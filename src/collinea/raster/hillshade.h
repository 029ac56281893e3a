// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "collinea/base/result.h"
#include "collinea/base/run.h"
#include "collinea/raster/raster.h"

namespace collinea {

/// How a cell faces a light in the north-west, 45 degrees high: the cosine of the angle between them, 0 where it is
/// turned away. The slope is Horn's (Proc. IEEE 69, 1981) over 3 x 3 cells; cells that are NaN or beyond the border are
/// as high as the middle one. NaN where that is.
[[nodiscard]] double hillshade_at(const FloatImage& heights_m, int x, int y, double cell_m);

/// Writes the image of a surface in that light: a cloud-optimised GeoTIFF on the same grid, 1 to 255 as the cosine
/// goes from 0 to 1, 0 where there is no height. Tile by tile. Errors: of the files, stopped.
[[nodiscard]] Result<> write_hillshade(const std::filesystem::path& heights, const std::filesystem::path& out,
                                       const Run& run);

}  // namespace collinea
