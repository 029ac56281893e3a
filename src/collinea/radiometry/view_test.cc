// SPDX-License-Identifier: Apache-2.0
#include "collinea/radiometry/view.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <numbers>

namespace collinea {
namespace {

// Nine images that look straight down, in several headings.
Block aerial() {
  Block block;
  block.cameras[CameraId{1}] = ideal_camera(250, 240, 200);
  const Eigen::Quaterniond down(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX()));
  for (std::uint32_t i = 0; i < 9; ++i) {
    const Eigen::Vector3d centre(4 + 12 * (i % 3), 4 + 12 * (i / 3), 50);
    const Eigen::Quaterniond rotation = Eigen::AngleAxisd(0.4 * i, Eigen::Vector3d::UnitZ()) * down;
    block.images[ImageId{10 + i}].camera = CameraId{1};
    set_pose(block, ImageId{10 + i}, {rotation, -(rotation * centre)});
  }
  return block;
}

TEST(LooksDown, TellsAerialFromFacade) {
  Block block = aerial();
  EXPECT_TRUE(looks_down(block));
  for (auto [id, pose] : oriented_images(block)) {
    pose.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(1.5, Eigen::Vector3d::UnitX())) * pose.rotation;
    set_pose(block, id, pose);
  }
  EXPECT_FALSE(looks_down(block));
  EXPECT_FALSE(looks_down(Block{}));
}

TEST(View, AnImageStraightAboveCostsLeastAndOneThatShowsNothingIsUseless) {
  const std::vector<View> views = views_of(aerial(), nullptr);
  ASSERT_EQ(views.size(), 9u);
  EXPECT_EQ(views[4].image, ImageId{14});
  EXPECT_EQ(views[4].centre_in_map, views[4].centre_in_world);
  const Eigen::Vector3d below(16, 16, 0);
  EXPECT_NEAR((*pixel_of(views[4], below) - Eigen::Vector2d(120, 100)).norm(), 0, 1e-9);
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (i != 4) {
      EXPECT_LT(cost_of(views[4], below, 0.2), cost_of(views[i], below, 0.2)) << i;
    }
  }
  EXPECT_GE(cost_of(views[4], {5000, 16, 0}, 0.2), kUseless);  // far beside the image
  EXPECT_GE(cost_of(views[4], {16, 16, 60}, 0.2), kUseless);   // behind the camera
}

}  // namespace
}  // namespace collinea
