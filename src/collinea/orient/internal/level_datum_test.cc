// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/internal/level_datum.h"

#include <gtest/gtest.h>

#include <numbers>

#include "collinea/geometry/rotation.h"

namespace collinea {
namespace {

// Images taken level, on a ring about something: the edges of the images tell what is level.
TEST(LevelDatum, AWalkRoundAThingIsLevelledByTheEdgesOfItsImages) {
  Block block;
  const Similarity3 world_from_block{3, rotation_by({0.4, -1, 2}), {10, 20, 30}};
  for (std::uint32_t i = 0; i < 12; ++i) {
    const double angle = 2 * std::numbers::pi * i / 12;
    const Eigen::Vector3d centre(5 * std::cos(angle), 5 * std::sin(angle), 1.5);
    Eigen::Matrix3d cam_from_world;  // 20 degrees down
    const Eigen::Vector3d forward = Eigen::Vector3d(-std::cos(angle), -std::sin(angle), -0.36).normalized();
    const Eigen::Vector3d right = forward.cross(Eigen::Vector3d::UnitZ()).normalized();
    cam_from_world << right.transpose(), forward.cross(right).transpose(), forward.transpose();
    const bool upright = i % 2;  // every other one with the camera turned by a quarter
    const Eigen::Quaterniond rotation =
        Eigen::AngleAxisd(upright ? std::numbers::pi / 2 : 0, Eigen::Vector3d::UnitZ()) *
        Eigen::Quaterniond(cam_from_world);
    set_pose(block, {i}, moved({rotation, -(rotation * centre)}, inverse(world_from_block)));
    block.images[{i}].orientation = upright ? 8 : 1;
    block.images[{i}].position =
        PositionPrior{{centre.x(), centre.y(), 0}, {0.5, 0.5, std::numeric_limits<double>::infinity()}};
  }
  const auto found = level_datum(block);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->level_by, LevelSource::kEdges);
  EXPECT_NEAR(found->world_from_block.scale, 3, 1e-6);
  EXPECT_LT(found->world_from_block.rotation.angularDistance(world_from_block.rotation), 1e-6);
  EXPECT_LT((found->world_from_block.translation - world_from_block.translation).head<2>().norm(), 1e-6);
  EXPECT_NEAR(found->rotation_sigma_rad, 0.5 / (5 * std::sqrt(12.0)), 1e-6);
  EXPECT_EQ(found->heights, 0u);
  for (auto& [id, image] : block.images) image.position->position_in_world.y() = 0;  // on a line
  for (auto [id, pose] : oriented_images(block)) {
    pose.translation = -(pose.rotation * Eigen::Vector3d(id.value, 0, 0));
    set_pose(block, id, pose);
  }
  EXPECT_FALSE(level_datum(block));
}
}  // namespace
}  // namespace collinea
