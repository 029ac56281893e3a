// SPDX-License-Identifier: Apache-2.0
#include "collinea/camera/camera.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "collinea/base/random.h"

namespace collinea {
namespace {

Camera distorted_camera() {
  Camera camera = ideal_camera(1000, 1200, 900);
  camera.params = {1000, 611, 447, -0.12, 0.05, -0.01, 0.002, -0.001, 3, 1.5};
  return camera;
}

TEST(Camera, OpticalAxisMeetsThePrincipalPoint) {
  EXPECT_EQ(*project(distorted_camera(), {0, 0, 5}), Eigen::Vector2d(611, 447));
}

TEST(Camera, DistanceAlongTheRayDoesNotMatter) {
  const Camera camera = distorted_camera();
  EXPECT_LT((*project(camera, {0.2, 0.3, 1}) - *project(camera, {0.4, 0.6, 2})).norm(), 1e-9);
}

TEST(Camera, PointsBehindHaveNoImage) { EXPECT_FALSE(project(distorted_camera(), {0, 0, -1})); }

TEST(Camera, PointsBeyondTheFoldHaveNoImage) {
  Camera camera = ideal_camera(1000, 1000, 1000);
  camera.params[Camera::kK1] = -0.3;  // grows until r = 1/sqrt(0.9)
  EXPECT_TRUE(project(camera, {1.0, 0, 1}));
  EXPECT_FALSE(project(camera, {1.1, 0, 1}));
  EXPECT_FALSE(project(camera, {5, 5, 1}));
}

TEST(Camera, NormalizedUndoesProject) {
  const Camera camera = distorted_camera();
  for (double column = 0; column <= 1200; column += 75)
    for (double row = 0; row <= 900; row += 75) {
      const auto back = project(camera, normalized(camera, {column, row}).homogeneous());
      ASSERT_TRUE(back);
      EXPECT_LT((*back - Eigen::Vector2d(column, row)).norm(), 1e-8);
    }
}

// Central differences of step h have error h^2/6 times the third derivative plus rounding 1e-16/h: 1e-6 relative is
// safe.
TEST(Camera, DerivativesAgreeWithNumericOnes) {
  const Camera camera = distorted_camera();
  Random random(1);
  for (int trial = 0; trial < 50; ++trial) {
    const Eigen::Vector3d point(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(2, 4));
    Matrix23 by_point;
    Matrix2P by_params;
    ASSERT_TRUE(project(camera, point, &by_point, &by_params));
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d step = 1e-5 * Eigen::Vector3d::Unit(k);
      const Eigen::Vector2d numeric = (*project(camera, point + step) - *project(camera, point - step)) / 2e-5;
      EXPECT_LT((numeric - by_point.col(k)).norm(), 1e-5);
    }
    for (int k = 0; k < Camera::kParams; ++k) {
      Camera plus = camera, minus = camera;
      plus.params[k] += 1e-5;
      minus.params[k] -= 1e-5;
      const Eigen::Vector2d numeric = (*project(plus, point) - *project(minus, point)) / 2e-5;
      EXPECT_LT((numeric - by_params.col(k)).norm(), 1e-5) << Camera::kParamNames[k];
    }
  }
}

}  // namespace
}  // namespace collinea
