// SPDX-License-Identifier: Apache-2.0
#include "collinea/block/world_frame.h"

namespace collinea {

Result<LocalFrame> world_frame(const Georeference& georeference) {
  return LocalFrame::create(georeference.crs, georeference.origin_latitude_deg, georeference.origin_longitude_deg,
                            georeference.origin_height_m);
}

Result<std::optional<LocalFrame>> world_frame(const Block& block) {
  if (!block.georeference) return std::nullopt;
  return world_frame(*block.georeference).map([](LocalFrame frame) { return std::optional(std::move(frame)); });
}

}  // namespace collinea
