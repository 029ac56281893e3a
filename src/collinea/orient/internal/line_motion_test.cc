// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/internal/line_motion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "collinea/geometry/rotation.h"
#include "collinea/orient/internal/test_pairs.h"
#include "collinea/orient/orient.h"

namespace collinea {
namespace {

struct Rotation {
  ImageId image;
  Eigen::Vector3d by_rad;  // from the first line to the last
  bool columns = false;    // the lines
};

// Twelve cameras round a heap; what they see to 0.3 px when those named turn while they are read out.
Block walk_round(const std::vector<Rotation>& rotations) {
  Random random(3);
  Block block;
  block.cameras[CameraId{1}] = ideal_camera(1500, 2000, 1500);
  block.cameras[CameraId{1}].name = "test";
  for (std::uint32_t i = 0; i < 12; ++i) {
    const double a = i * std::numbers::pi / 6;
    const Eigen::Vector3d centre(40 * std::cos(a), 40 * std::sin(a), 30.0 + 4 * (i % 2));
    const Eigen::Vector3d z = -centre.normalized(), x = z.cross(Eigen::Vector3d::UnitZ()).normalized();
    Eigen::Matrix3d cam_from_world;
    cam_from_world << x.transpose(), z.cross(x).transpose(), z.transpose();
    block.images[ImageId{i}] = {"IMG_" + std::to_string(i) + ".jpg", CameraId{1}, "", {}, {}, 1};
    set_pose(block, ImageId{i}, {Eigen::Quaterniond(cam_from_world), -(cam_from_world * centre)});
  }
  const Camera& camera = block.cameras.at(CameraId{1});
  for (std::uint32_t p = 0; p < 700; ++p) {
    const double x = random.uniform(-14, 14), y = random.uniform(-12, 12);
    const Eigen::Vector3d point(x, y, random.uniform(-6, 6));
    block.points[PointId{p}].position_in_world = point;
    for (const auto& [id, pose] : oriented_images(block)) {
      auto pixel = project(camera, pose * point);
      for (const Rotation& rotation : rotations)
        for (int round = 0; round < 3 && rotation.image == id && pixel; ++round) {  // the line depends on the pixel
          const double line = rotation.columns ? pixel->x() / camera.width_px : pixel->y() / camera.height_px;
          pixel = project(camera, rotation_by((line - 0.5) * rotation.by_rad) * (pose * point));
        }
      if (!pixel || !inside(camera, *pixel)) continue;
      const double u = random.normal(), v = random.normal();
      block.observations.push_back({id, PointId{p}, 0, *pixel + 0.3 * Eigen::Vector2d(u, v), 0.3});
    }
  }
  return block;
}

TEST(LineMotion, NoiseAloneShowsNone) {
  const LineMotion motion = line_motion(walk_round({}));
  ASSERT_EQ(motion.images.size(), 12U);
  EXPECT_LT(std::abs(motion.explained), 0.005);
  EXPECT_LT(motion.images.front().explained, 0.03);
}

TEST(LineMotion, ATurnIsFoundInItsImage) {
  for (const bool columns : {false, true}) {
    const LineMotion motion = line_motion(walk_round({{ImageId{4}, {0.003, -0.0018, 0.0024}, columns}}));
    EXPECT_EQ(motion.images.front().image, ImageId{4});
    EXPECT_GT(motion.images.front().explained, 0.2);
    EXPECT_LT(motion.images[1].explained, 0.03);
  }
}

std::vector<Finding> findings_after_orientation(const std::vector<Rotation>& rotations) {
  const auto input = testing::matched(walk_round(rotations));
  const auto found = orient(input.setup, input.pairs, input.source(), {}, {});
  EXPECT_TRUE(found) << found.error().message;
  return found ? found->findings : std::vector<Finding>{};
}

TEST(LineMotion, IsNamedWhenTheHandMoved) {
  Random random(8);
  std::vector<Rotation> rotations;
  for (std::uint32_t i = 0; i < 12; ++i) rotations.push_back({ImageId{i}, 0.004 * testing::normal3(random), false});
  const auto named = [](const std::vector<Finding>& findings) {
    return std::any_of(findings.begin(), findings.end(),
                       [](const Finding& one) { return one.code == FindingCode::kMovedWhileRead; });
  };
  EXPECT_TRUE(named(findings_after_orientation(rotations)));
  EXPECT_FALSE(named(findings_after_orientation({})));
}

TEST(LineMotion, ABlockWithoutLongTracksSaysNothing) {
  Block block = walk_round({});
  std::erase_if(block.observations, [](const Observation& seen) { return seen.image.value > 1; });
  EXPECT_TRUE(line_motion(block).images.empty());
  EXPECT_EQ(line_motion({}).explained, 0);
}

}  // namespace
}  // namespace collinea
