// SPDX-License-Identifier: Apache-2.0
#include "collinea/block/transform.h"

namespace collinea {

void transform(Block& block, const Similarity3& world_from_block) {
  for (const auto& [image, pose] : oriented_images(block)) set_pose(block, image, moved(pose, world_from_block));
  for (auto& [id, point] : block.points) point.position_in_world = world_from_block * point.position_in_world;
}

}  // namespace collinea
