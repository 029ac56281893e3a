// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/vector/vector_layer.h"

namespace collinea {

/// Writes the layers into one drawing (DXF, by GDAL), atomically: points, polylines, closed polylines of polygons and
/// of their holes, each on the layer of its name, in the colour of its style; fields are left out. Characters of layer names that a drawing does
/// not take become "_". Error: not writable.
[[nodiscard]] Result<> write_dxf(const std::filesystem::path& path, const std::vector<VectorLayer>& layers);

}  // namespace collinea
