// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/block/block.h"
#include "collinea/store/step_records.h"

namespace collinea {

/// The counts of what was set up; nothing skipped, nothing found.
[[nodiscard]] inline ImportRecord record_of(const Block& setup) {
  ImportRecord record{.images = setup.images.size(),
                      .cameras = setup.cameras.size(),
                      .control_points = setup.control.size(),
                      .geodetic_observations = setup.geodetic.size()};
  for (const auto& [id, image] : setup.images) record.positions += image.position.has_value();
  if (setup.georeference) record.crs = setup.georeference->crs;
  return record;
}

}  // namespace collinea
