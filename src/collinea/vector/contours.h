// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>

#include "collinea/raster/geotiff.h"

namespace collinea {

/// Writes the contours of a raster of heights [m] (NaN: nothing there), through the centres of its cells, at all
/// multiples of `interval_m`: a GeoPackage with one layer "contours" (field height_m, lines with heights) in the CRS of
/// the grid, and a DXF drawing of the same lines. Lines shorter than `shortest_m` are left out: rings around a bush.
/// Returns the number of lines. By GDAL. The same heights give the same bytes. Errors: not writable, GDAL without these
/// formats.
[[nodiscard]] Result<std::uint64_t> write_contours(FloatImage heights_m, const MapGrid& grid, double interval_m,
                                                   double shortest_m, const std::filesystem::path& geopackage,
                                                   const std::filesystem::path& dxf);

}  // namespace collinea
