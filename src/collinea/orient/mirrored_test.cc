// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/mirrored.h"

#include <gtest/gtest.h>

#include "collinea/adjust/test_block.h"
#include "collinea/quality/mark_systems.h"

namespace collinea {
namespace {

using testing::test_block;

// A block as a file of measurements states it, counted in another system.
Block written_in(MarkSystem system, double relief_m, bool with_poses, std::uint64_t seed = 1) {
  Block block = test_block(
      {.rows = 2, .columns = 4, .relief_m = relief_m, .sigma_px = 0.5, .control = 40, .tilt_rad = 0.05, .seed = seed});
  const auto write = [&](auto& seen) {
    const Camera& camera = block.camera_of(seen.image);
    const MarkMap map = map_of({system, 1}, camera.width_px, camera.height_px);
    seen.pixel = map.linear.inverse() * (seen.pixel - map.origin);
  };
  for (Observation& seen : block.observations) write(seen);
  for (ControlObservation& seen : block.control_observations) write(seen);
  if (!with_poses) clear_poses(block);
  return block;
}

TEST(Mirrored, RowsCountedUpwardsAreNamed) {
  for (const MarkSystem system : {MarkSystem::kRowsUp, MarkSystem::kExchanged, MarkSystem::kCentreRowsUp}) {
    const auto found = mirrored_measurements(written_in(system, 8, false), 1);
    ASSERT_EQ(found.size(), 1u) << word_of(system);
    EXPECT_EQ(found[0].code, FindingCode::kMarksMirrored);
    EXPECT_EQ(found[0].detail, word_of(system));
    EXPECT_EQ(found[0].severity, Severity::kWrong);
    EXPECT_GT(found[0].figure(FigureName::kRatio).value(), 3);
    EXPECT_LT(found[0].figure(FigureName::kOffsetPx).value(), 2);
  }
}

// What the images of flat ground show mirrored is the same ground from beneath: both fit, and that is only noted.
TEST(Mirrored, CamerasBeneathFlatGroundAreNoted) {
  for (const MarkSystem system : {MarkSystem::kAsGiven, MarkSystem::kRowsUp}) {
    Block block = test_block({.rows = 2, .columns = 4, .sigma_px = 0.5, .control = 40, .tilt_rad = 0.05});
    Random random(3);
    for (auto& [id, point] : block.control) point.position_in_world.z() = 0;
    for (ControlObservation& seen : block.control_observations) {
      const Camera& camera = block.camera_of(seen.image);
      const double du = random.normal(), dv = random.normal();
      const Eigen::Vector3d in_cam = pose_of(block, seen.image) * block.control.at(seen.point).position_in_world;
      const Eigen::Vector2d pixel = *project(camera, in_cam) + 0.5 * Eigen::Vector2d(du, dv);
      seen.pixel = pixel_of({system}, camera, pixel);  // rows upwards are their own inverse
    }
    clear_poses(block);
    const auto found = mirrored_measurements(block, 1);
    if (system == MarkSystem::kAsGiven) {
      EXPECT_TRUE(found.empty());
      continue;
    }
    ASSERT_EQ(found.size(), 1u);
    EXPECT_EQ(found[0].detail, "rows_up");
    EXPECT_LT(found[0].figure(FigureName::kOffsetPx).value(), 2);
  }
}

TEST(Mirrored, WherePosesAreStatedTiePointsTell) {
  Block block = written_in(MarkSystem::kRowsUp, 8, true);
  block.control_observations.clear();
  const auto found = mirrored_measurements(block, 1);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].code, FindingCode::kMarksCountedOtherwise);
  EXPECT_EQ(found[0].detail, "rows_up");
}

TEST(Mirrored, GoodMeasurementsGiveNoFinding) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed)
    for (const bool with_poses : {false, true})
      for (const double relief_m : {0.0, 8.0})
        EXPECT_TRUE(mirrored_measurements(written_in(MarkSystem::kAsGiven, relief_m, with_poses, seed), 1).empty())
            << seed;
  EXPECT_TRUE(mirrored_measurements({}, 1).empty());
}

}  // namespace
}  // namespace collinea
