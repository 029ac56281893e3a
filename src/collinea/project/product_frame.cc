// SPDX-License-Identifier: Apache-2.0
#include "collinea/project/product_frame.h"

#include "collinea/block/world_frame.h"

namespace collinea {

Result<ProductFrame> product_frame_of(const Project& project, const Block& block) {
  COLLINEA_TRY(const auto oriented, project.store.read_outcome<OrientationRecord>());
  ProductFrame product_frame;
  product_frame.pixel_m = oriented.pixel_size;
  int shrink = 1;
  for (const auto& [id, camera] : block.cameras) {
    COLLINEA_TRY(const int of_camera, working_shrink(camera, project.settings.densify));
    shrink = std::max(shrink, of_camera);
  }
  product_frame.matched_pixel_m = shrink * product_frame.pixel_m;
  product_frame.metric = oriented.metric;
  if (oriented.georeferenced) {
    COLLINEA_TRY(product_frame.frame, world_frame(*block.georeference));
  }
  return product_frame;
}

}  // namespace collinea
