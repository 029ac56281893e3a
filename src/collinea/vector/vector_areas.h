// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "collinea/base/result.h"

namespace collinea {

/// A ring of a polygon, closed by itself [m in the map].
using MapRing = std::vector<Eigen::Vector2d>;

/// A polygon of a vector file with the name it bears.
struct NamedArea {
  std::int64_t feature = 0;    ///< its number in the file
  std::string name;            ///< what its field says
  std::vector<MapRing> rings;  ///< the outline and its holes; a feature of several parts gives several areas
};

/// Reads the polygons of a vector file (GeoPackage, whatever GDAL knows) in their order: of its first layer that has
/// the text field `field`. `wkt`: the CRS they must be in; empty: the file must not claim one either. Errors: missing,
/// not a vector file, no such layer, another CRS, a feature that is no polygon, has no name or whose outline is broken
/// (crosses itself, is not finite); each says which.
[[nodiscard]] Result<std::vector<NamedArea>> read_areas(const std::filesystem::path& path, const std::string& field,
                                                        const std::string& wkt);

}  // namespace collinea
