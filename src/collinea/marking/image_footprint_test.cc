// SPDX-License-Identifier: Apache-2.0
#include "collinea/marking/image_footprint.h"

#include <gtest/gtest.h>

namespace collinea {
namespace {

// x east, y south, z down.
Rigid3 looking_down(const Eigen::Vector3d& centre) {
  const Eigen::Quaterniond rotation(Eigen::AngleAxisd(EIGEN_PI, Eigen::Vector3d::UnitX()));
  return {rotation, -(rotation * centre)};
}

TEST(ImageFootprint, OfAVerticalImageIsItsFormatAtScale) {
  const Camera camera = ideal_camera(1000, 2000, 1000);
  const auto outline = image_footprint(camera, looking_down({10, 20, 130}), 30);
  ASSERT_TRUE(outline);
  ASSERT_EQ(outline->size(), 16u);
  EXPECT_LT(((*outline)[0] - Eigen::Vector3d(-90, 70, 30)).norm(), 1e-9);  // 100 m over 1000 px: 0.1 m a pixel
  EXPECT_LT(((*outline)[8] - Eigen::Vector3d(110, -30, 30)).norm(), 1e-9);
}

TEST(ImageFootprint, ThereIsNoneOverTheHorizon) {
  const Camera camera = ideal_camera(1000, 2000, 1000);
  Rigid3 pose = looking_down({0, 0, 100});
  EXPECT_FALSE(image_footprint(camera, pose, 101));  // the plane is behind it
  pose.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(1.2, Eigen::Vector3d::UnitX())) * pose.rotation;
  pose.translation = -(pose.rotation * Eigen::Vector3d(0, 0, 100));
  EXPECT_FALSE(image_footprint(camera, pose, 0));
}

}  // namespace
}  // namespace collinea
