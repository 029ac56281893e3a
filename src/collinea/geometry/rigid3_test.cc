// SPDX-License-Identifier: Apache-2.0
#include "collinea/geometry/rigid3.h"

#include <gtest/gtest.h>

namespace collinea {
namespace {

TEST(Rigid3, InverseUndoesTheMotion) {
  const Rigid3 cam_from_world{Eigen::Quaterniond(0.5, 0.5, -0.5, 0.5), {1, 2, 3}};
  const Eigen::Vector3d point_in_world(4, 5, 6);
  const Eigen::Vector3d there_and_back = inverse(cam_from_world) * (cam_from_world * point_in_world);
  EXPECT_LT((there_and_back - point_in_world).norm(), 1e-12);
}

}  // namespace
}  // namespace collinea
