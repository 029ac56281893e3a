// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "collinea/base/result.h"
#include "collinea/base/run.h"
#include "collinea/raster/geotiff.h"
#include "collinea/raster/raster.h"
#include "collinea/vector/contours.h"

namespace collinea {

/// The land as contours are drawn of it: means of the ground in coarse cells.
struct CoarseTerrain {
  MapGrid grid;
  FloatImage height_m;           ///< everywhere, continued where there is no ground
  Raster<std::uint8_t> covered;  ///< 1 where the surface model has anything
  double usual_sigma_m = 0;      ///< of a height against those around it
};

/// The interval of contours that shows the relief in twenty lines at most and does not draw noise: 1, 2 or 5 times a
/// power of ten [m]. Strays at either end of the heights do not count as relief. 0 for flat land without errors, and
/// where nothing is covered.
[[nodiscard]] double contour_interval_m(const CoarseTerrain& terrain);

/// Draws contours of the blurred terrain into a GeoPackage and a DXF drawing of the same name; returns how many.
/// Errors: kCancelled, and those of writing.
[[nodiscard]] Result<std::size_t> draw_terrain_contours(CoarseTerrain terrain, double interval_m,
                                                        const std::filesystem::path& file,
                                                        const std::filesystem::path& drawing, const Run& run);

}  // namespace collinea
