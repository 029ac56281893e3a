// SPDX-License-Identifier: Apache-2.0
#include "collinea/block/image_axes.h"

#include <gtest/gtest.h>

namespace collinea {
namespace {

TEST(ImageAxes, AttitudesAreThoseOfDrones) {
  const auto world_from_cam = [](const AttitudePrior& attitude) { return cam_from_world(attitude).conjugate(); };
  // Straight down, heading north: the upper edge of the image is in the north.
  EXPECT_LT((world_from_cam({0, -90, 0}) * Eigen::Vector3d(0, -1, 0) - Eigen::Vector3d::UnitY()).norm(), 1e-12);
  EXPECT_LT((world_from_cam({90, 0, 0}) * Eigen::Vector3d::UnitZ() - Eigen::Vector3d::UnitX()).norm(), 1e-12);
  // Rolled to the right the right edge is the lower one.
  EXPECT_LT((world_from_cam({0, 0, 90}) * Eigen::Vector3d::UnitX() + Eigen::Vector3d::UnitZ()).norm(), 1e-12);
}

}  // namespace
}  // namespace collinea
