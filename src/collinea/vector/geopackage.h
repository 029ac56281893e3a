// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/vector/vector_layer.h"

namespace collinea {

/// Writes the layers into one GeoPackage, atomically. Styles go into a table layer_styles, as QGIS keeps its own.
/// `wkt`: of the CRS; empty: a local frame. The same layers give the same bytes. By GDAL. Errors: not writable, GDAL
/// without the format.
[[nodiscard]] Result<> write_geopackage(const std::filesystem::path& path, const std::vector<VectorLayer>& layers,
                                        const std::string& wkt);

}  // namespace collinea
