// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/internal/strip_datum.h"

#include <gtest/gtest.h>

#include <numbers>

#include "collinea/orient/internal/test_pairs.h"

namespace collinea {
namespace {

using testing::straight_strip;

TEST(StripDatum, ExactPositionsAndAttitudesGiveTheExactFrame) {
  for (const double pitch_deg : {-90.0, -40.0, 0.0})
    for (const double roll_deg : {0.0, 25.0, -70.0}) {
      Block block;
      const AttitudePrior attitude{0, pitch_deg, roll_deg};  // heading north
      const double pitch = pitch_deg * std::numbers::pi / 180, roll = roll_deg * std::numbers::pi / 180;
      // Columns: the camera's axes in the world, before roll.
      Eigen::Matrix3d world_from_cam;
      world_from_cam << 1, 0, 0, 0, std::sin(pitch), std::cos(pitch), 0, -std::cos(pitch), std::sin(pitch);
      world_from_cam = world_from_cam * Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitZ());
      const Similarity3 world_from_block{3, rotation_by({0.4, -1, 2}), {10, 20, 30}};
      for (std::uint32_t i = 0; i < 4; ++i) {
        const ImageId id{i};
        const Eigen::Vector3d centre(20 * i, 5 * i, 100);
        const Rigid3 pose{Eigen::Quaterniond(world_from_cam).conjugate(), -(world_from_cam.transpose() * centre)};
        set_pose(block, id, moved(pose, inverse(world_from_block)));
        block.images[id].position = PositionPrior{centre, Eigen::Vector3d::Constant(0.1)};
        block.images[id].attitude = attitude;
      }
      const auto found = strip_datum(block);
      ASSERT_TRUE(found) << pitch_deg << " " << roll_deg;
      EXPECT_NEAR(found->scale, 3, 1e-9);
      EXPECT_LT(found->rotation.angularDistance(world_from_block.rotation), 1e-7) << pitch_deg << " " << roll_deg;
      EXPECT_LT((found->translation - world_from_block.translation).norm(), 1e-7);
    }
}

TEST(StripDatum, TheRotationIsTheWorseKnownTheStraighterTheLine) {
  Block block;
  for (std::uint32_t i = 0; i < 4; ++i) {
    const Eigen::Vector3d centre(10.0 * i, i % 2 ? 0.5 : -0.5, 0);  // in the block; half as large as in the world
    set_pose(block, {i}, {Eigen::Quaterniond::Identity(), -centre});
    block.images[{i}].position = PositionPrior{2 * centre, Eigen::Vector3d::Constant(0.3)};
  }
  // Levers of about 1 m, four of them: 0.3 / sqrt(4); the line itself slants a little along the zigzag.
  EXPECT_NEAR(rotation_sigma_rad(block, 2), 0.15, 0.02);
  block.images.erase({3});
  remove_pose(block, {3});
  EXPECT_TRUE(std::isfinite(rotation_sigma_rad(block, 2)));
  block.images.at({0}).position.reset();
  EXPECT_TRUE(std::isinf(rotation_sigma_rad(block, 2)));
}

// The first and the last station of a line flown there and back are nearly the same, one above the other.
TEST(StripDatum, ALineFlownThereAndBackHasADirection) {
  Block strip = straight_strip();
  const auto count = static_cast<std::uint32_t>(strip.images.size());
  const std::uint32_t first = strip.images.begin()->first.value;
  for (std::uint32_t i = 0; i < count; ++i) {
    Image back = strip.images.at({first + count - 1 - i});
    back.position->position_in_world.z() += 2;
    Rigid3 pose = pose_of(strip, {first + count - 1 - i});
    pose.translation -= pose.rotation * Eigen::Vector3d(0, 0, 2);
    strip.images[{first + count + i}] = back;
    set_pose(strip, {first + count + i}, pose);
  }
  const auto found = strip_datum(strip);
  ASSERT_TRUE(found);
  EXPECT_LT(found->rotation.angularDistance(Eigen::Quaterniond::Identity()), 0.1);
}

// 1 / sqrt(sum of lever^2 / sigma^2): one vague position among good ones takes away its own share only.
TEST(StripDatum, EveryPositionCountsByItsOwnSigma) {
  Block block;
  for (std::uint32_t i = 0; i < 18; ++i) {
    const Eigen::Vector3d centre(10.0 * (i / 2), i % 2 ? 5 : -5, 0);
    set_pose(block, {i}, {Eigen::Quaterniond::Identity(), -centre});
    block.images[{i}].position = PositionPrior{centre, Eigen::Vector3d::Constant(0.02)};
  }
  EXPECT_NEAR(rotation_sigma_rad(block, 1), 0.02 / (5 * std::sqrt(18.0)), 1e-6);
  block.images.at({7}).position->sigma_m.setConstant(30);
  EXPECT_NEAR(rotation_sigma_rad(block, 1), 0.02 / (5 * std::sqrt(17.0)), 0.02 * 0.02 / 5);
  Block strip = straight_strip();
  for (auto& [id, image] : strip.images) image.position->sigma_m.setConstant(0.02);
  ImageId vague = strip.images.rbegin()->first;
  strip.images.at(vague).position->sigma_m.setConstant(300);
  strip.images.at(vague).position->position_in_world.x() += 250;
  const auto found = strip_datum(strip);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->scale, 1, 0.1);  // the others err by 3 m over 150 m
}

TEST(StripDatum, ContradictingAttitudesOrAShortLineGiveNone) {
  const Block good = straight_strip();
  ASSERT_TRUE(strip_datum(good));
  Block contradicting = good;
  contradicting.images.begin()->second.attitude->pitch_deg = 30;
  EXPECT_FALSE(strip_datum(contradicting));
  Block vague = good;
  for (auto& [id, image] : vague.images) image.position->sigma_m.setConstant(20);
  EXPECT_FALSE(strip_datum(vague));
}
}  // namespace
}  // namespace collinea
