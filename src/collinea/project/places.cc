// SPDX-License-Identifier: Apache-2.0
#include "collinea/project/places.h"

#include "collinea/block/world_frame.h"

namespace collinea {

Result<Places> places_of(const Project& project, const Block& block) {
  COLLINEA_TRY(const auto oriented, project.store.read_outcome<OrientationRecord>());
  Places places;
  places.pixel_m = oriented.pixel_size;
  int shrink = 1;
  for (const auto& [id, camera] : block.cameras) {
    COLLINEA_TRY(const int of_camera, working_shrink(camera, project.settings.densify));
    shrink = std::max(shrink, of_camera);
  }
  places.matched_pixel_m = shrink * places.pixel_m;
  places.metric = oriented.metric;
  if (oriented.georeferenced) {
    COLLINEA_TRY(places.frame, world_frame(*block.georeference));
  }
  return places;
}

}  // namespace collinea
