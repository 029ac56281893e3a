// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/drawing_files.h"

#include "collinea/base/file.h"
#include "collinea/block/world_frame.h"
#include "collinea/vector/dxf.h"
#include "collinea/vector/geopackage.h"

namespace collinea {

Result<DrawingFiles> write_drawing(const Project& project, const Drawing& drawing, std::span<const DrawingCode> codes) {
  COLLINEA_TRY(const Block block, project.store.read_setup());
  COLLINEA_TRY(const std::optional<LocalFrame> frame, world_frame(block));
  const std::filesystem::path products = project.folder / "products";
  std::error_code ignored;
  std::filesystem::create_directories(products, ignored);
  DrawingFiles written{frame ? frame->crs() : "", {"products/drawing.gpkg", "products/drawing.dxf"}};
  COLLINEA_TRY(write_geopackage(products / "drawing.gpkg", vector_layers(drawing, codes), frame ? frame->wkt1() : ""));
  const std::vector<VectorLayer> plain = plain_layers(drawing, codes);
  COLLINEA_TRY(write_dxf(products / "drawing.dxf", plain));
  if (!frame) {
    for (const char* name : {"drawing.vrt", "drawing.prj"}) COLLINEA_TRY(remove_file(products / name));
    return written;
  }
  COLLINEA_TRY(write_dxf_layers(products / "drawing.vrt", "drawing.dxf", plain, frame->wkt1()));
  COLLINEA_TRY(write_file(products / "drawing.prj", frame->wkt1() + "\n"));
  for (const char* file : {"products/drawing.vrt", "products/drawing.prj"}) written.files.emplace_back(file);
  return written;
}

}  // namespace collinea
