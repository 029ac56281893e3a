// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/adjusted.h"

namespace collinea {

void apply(const Adjusted& adjusted, Block& block) {
  for (const auto& [id, pose] : adjusted.cam_from_world) set_pose(block, id, pose);
  for (const auto& [id, camera] : adjusted.cameras) block.cameras[id] = camera;
  auto known = block.points.begin();
  for (const auto& [id, position] : adjusted.points) {
    if (known != block.points.end() && known->first < id) ++known;
    if (known == block.points.end() || known->first != id) known = block.points.lower_bound(id);
    if (known != block.points.end() && known->first == id) known->second.position_in_world = position;
  }
}

}  // namespace collinea
