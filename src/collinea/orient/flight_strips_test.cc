// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/flight_strips.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdio>

namespace collinea {
namespace {

// Strips there and back, ten metres and two seconds an image.
Block flown(int strips, int images, bool timed) {
  Block block;
  block.cameras[{1}] = {};
  int second = 0;
  for (int s = 0; s < strips; ++s)
    for (int i = 0; i < images; ++i, second += 2) {
      const ImageId id{static_cast<std::uint32_t>(s * images + i)};
      const Eigen::Vector3d centre(10.0 * (s % 2 ? images - 1 - i : i), 30.0 * s, 80);
      set_pose(block, id, {Eigen::Quaterniond::Identity(), -centre});
      char taken[40];
      std::snprintf(taken, sizeof taken, "2024:02:29 23:%02d:%02d.50", 58 + second / 60, second % 60);
      char name[40];
      std::snprintf(name, sizeof name, "IMG_%04u.jpg", id.value);
      block.images[id] = {name, {1}, timed ? taken : "", PositionPrior{}, {}, 1};
    }
  return block;
}

TEST(FlightStrips, AreCutWhereThePathTurns) {
  for (const bool timed : {true, false}) {
    const auto strips = flight_strips(flown(4, 6, timed));
    ASSERT_EQ(strips.size(), 4u);
    for (std::uint32_t s = 0; s < 4; ++s) EXPECT_TRUE(strips[s].contains({6 * s + 3})) << s;
    EXPECT_NEAR(strips[1].at({8}) - strips[1].at({7}), timed ? 2 : 1, 1e-9);
    EXPECT_EQ(one_strip(flown(4, 6, timed)).size(), 1u);
  }
}

TEST(FlightStrips, APauseBeginsANewOne) {
  Block block = flown(1, 8, true);
  for (std::uint32_t i = 4; i < 8; ++i) block.images.at({i}).taken = "2024:03:01 08:00:0" + std::to_string(2 * (i - 4));
  EXPECT_EQ(flight_strips(block).size(), 2u);
}

// Five metres a second, there and back; also at the ends of strips, and where times are whole seconds.
TEST(FlightStrips, VelocitiesAreThoseOfTheStrip) {
  const auto velocities = flight_velocities(flown(2, 6, true));
  ASSERT_EQ(velocities.size(), 12u);
  for (const auto& [id, velocity] : velocities)
    EXPECT_LT((velocity - Eigen::Vector3d(id.value < 6 ? 5 : -5, 0, 0)).norm(), 1e-6) << id.value;
  Block rounded = flown(1, 6, true);
  for (auto [id, pose] : oriented_images(rounded)) {
    pose.translation.x() *= 0.9;
    set_pose(rounded, id, pose);
  }                                      // 9 m in 1.8 s ...
  for (std::uint32_t i = 0; i < 6; ++i)  // ... which the clock does not show
    rounded.images.at({i}).taken = "2024:03:01 08:00:0" + std::to_string(static_cast<int>(1.8 * i));
  for (const auto& [id, velocity] : flight_velocities(rounded)) EXPECT_NEAR(velocity.x(), 5, 0.8) << id.value;
  EXPECT_TRUE(flight_velocities(flown(2, 6, false)).empty());
}

// 2 m/s^2 from standing still, every 0.9 s and in the end every 1.8 s; two cameras at each time.
TEST(FlightStrips, AccelerationsAreFollowed) {
  Block block = flown(1, 12, true);
  const auto time_s = [](std::uint32_t i) { return i < 10 ? 0.9 * (i / 2) : 0.9 * 6; };
  for (std::uint32_t i = 0; i < 12; ++i) {
    Rigid3 pose = pose_of(block, {i});
    pose.translation = -(pose.rotation * Eigen::Vector3d(time_s(i) * time_s(i), 20, 100));
    set_pose(block, {i}, pose);
    block.images.at({i}).taken = fmt::format("2024:03:01 08:00:{:04.1f}", 10 + time_s(i));
  }
  const auto velocities = flight_velocities(block);
  ASSERT_EQ(velocities.size(), 12u);
  for (const auto& [id, velocity] : velocities)
    EXPECT_LT((velocity - Eigen::Vector3d(2 * time_s(id.value), 0, 0)).norm(), 1e-4) << id.value;
}

TEST(FlightStrips, WithoutPositionsThereAreNone) {
  Block block = flown(2, 4, true);
  for (auto& [id, image] : block.images) image.position.reset();
  EXPECT_TRUE(flight_strips(block).empty());
  EXPECT_TRUE(one_strip(block).empty());
}

}  // namespace
}  // namespace collinea
