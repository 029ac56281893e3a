// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/vector/vector_layer.h"

namespace collinea {

/// Names that SQLite, GeoPackage and QGIS keep for their own tables, whatever their case: sqlite_..., gpkg_...,
/// rtree_..., layer_styles.
[[nodiscard]] bool is_reserved_table(std::string_view name);

/// Writes the layers into one GeoPackage, atomically. Styles go into a table layer_styles, as QGIS keeps its own.
/// `wkt`: of the CRS; empty: a local frame. The same layers give the same bytes. By GDAL. Errors: kBadInput, a name of
/// a layer that is empty, reserved, or stands twice (whatever its case); not writable, GDAL without the format.
[[nodiscard]] Result<> write_geopackage(const std::filesystem::path& path, const std::vector<VectorLayer>& layers,
                                        const std::string& wkt);

}  // namespace collinea
