// SPDX-License-Identifier: Apache-2.0
#include "collinea/block/block.h"

#include "collinea/base/result.h"

namespace collinea {

Rigid3 pose_of(const Block& block, ImageId image) {
  const std::optional<Rigid3> pose = find_pose(block, image);
  COLLINEA_CHECK(pose.has_value());
  return *pose;
}

std::optional<Rigid3> find_pose(const Block& block, ImageId image) {
  const auto& table = block.poses.cam_from_world_;
  const auto found = table.find(image);
  return found == table.end() ? std::nullopt : std::optional(found->second);
}

bool is_oriented(const Block& block, ImageId image) { return block.poses.cam_from_world_.contains(image); }

std::size_t count_oriented(const Block& block) { return block.poses.cam_from_world_.size(); }

std::vector<OrientedImage> oriented_images(const Block& block) {
  const auto& table = block.poses.cam_from_world_;
  std::vector<OrientedImage> images;
  images.reserve(table.size());
  for (const auto& [image, pose] : table) images.push_back({image, pose});
  return images;
}

void set_pose(Block& block, ImageId image, const Rigid3& cam_from_world) {
  block.poses.cam_from_world_.insert_or_assign(image, cam_from_world);
}

void set_poses(Block& block, std::map<ImageId, Rigid3> cam_from_world) {
  block.poses.cam_from_world_ = std::move(cam_from_world);
}

void remove_pose(Block& block, ImageId image) { block.poses.cam_from_world_.erase(image); }

void clear_poses(Block& block) { set_poses(block, {}); }

}  // namespace collinea
