// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/project/project.h"
#include "collinea/vector/drawing.h"

namespace collinea {

struct DrawingFiles {
  std::string crs;                 ///< empty: the frame of the block
  std::vector<std::string> files;  ///< below the project
};

/// Writes a drawing of a project: products/drawing.gpkg (vector_layers()), products/drawing.dxf (plain_layers()) and,
/// as a DXF has no CRS of its own, products/drawing.vrt, by which GDAL reads its layers in it (write_dxf_layers()), and
/// products/drawing.prj; without a CRS neither is there. Errors: not writable; the CRS of the block.
[[nodiscard]] Result<DrawingFiles> write_drawing(const Project& project, const Drawing& drawing,
                                                 std::span<const DrawingCode> codes);

}  // namespace collinea
