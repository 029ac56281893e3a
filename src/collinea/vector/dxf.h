// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/vector/vector_layer.h"

namespace collinea {

/// Writes the layers into one drawing (DXF, by GDAL), atomically: points, polylines, closed polylines of polygons and
/// of their holes, each on the layer of its name, in the colour of its style; fields are left out. Characters of layer
/// names that a drawing does not take become "_". Error: not writable.
[[nodiscard]] Result<> write_dxf(const std::filesystem::path& path, const std::vector<VectorLayer>& layers);

/// Writes an OGR virtual dataset (VRT) of a drawing beside it, which has no CRS: what reads it by GDAL sees each layer
/// of the drawing by itself, in the CRS of `wkt`. `layers`: as write_dxf() wrote them into `dxf`, a file in the same
/// folder. Error: not writable.
[[nodiscard]] Result<> write_dxf_layers(const std::filesystem::path& path, const std::string& dxf,
                                        const std::vector<VectorLayer>& layers, const std::string& wkt);

}  // namespace collinea
