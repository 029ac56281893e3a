// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <span>
#include <vector>

#include "collinea/block/block.h"
#include "collinea/ortho/seamlines.h"

namespace collinea {

/// Writes seamlines as the layer "seamlines" of a GeoPackage: polygons with the file name of their image in the
/// field "image". `sources`: the images that SeamPolygon::source counts, from 1 on. `wkt`: of the CRS of the map.
[[nodiscard]] Result<> write_seamlines(const std::filesystem::path& path, const std::vector<SeamPolygon>& seamlines,
                                       const Block& block, std::span<const ImageId> sources, const std::string& wkt);

/// Reads them, also after they were edited. Errors: as of read_areas; an image that the project does not have or
/// that is not among the sources.
[[nodiscard]] Result<std::vector<SeamPolygon>> read_seamlines(const std::filesystem::path& path, const Block& block,
                                                              std::span<const ImageId> sources, const std::string& wkt);

}  // namespace collinea
