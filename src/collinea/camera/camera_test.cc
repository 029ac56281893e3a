// SPDX-License-Identifier: Apache-2.0
#include "collinea/camera/camera.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "collinea/base/random.h"

namespace collinea {
namespace {

Camera distorted_camera(CameraModel model = CameraModel::kBrown) {
  Camera camera = ideal_camera(1000, 1200, 900);
  camera.model = model;
  camera.params = {1000, 611, 447, -0.12, 0.05, -0.01, 0.002, -0.001, 3, 1.5};
  return camera;
}

// Laws of every model.
class CameraLaws : public ::testing::TestWithParam<CameraModel> {
 protected:
  const Camera camera = distorted_camera(GetParam());
};

INSTANTIATE_TEST_SUITE_P(Models, CameraLaws,
                         ::testing::Values(CameraModel::kBrown, CameraModel::kBrownOfMeasured),
                         [](const auto& tested) { return std::string(kCameraModelNames[std::size_t(tested.param)]); });

TEST_P(CameraLaws, OpticalAxisMeetsThePrincipalPoint) {
  EXPECT_EQ(*project(camera, {0, 0, 5}), Eigen::Vector2d(611, 447));
}

TEST_P(CameraLaws, DistanceAlongTheRayDoesNotMatter) {
  EXPECT_LT((*project(camera, {0.2, 0.3, 1}) - *project(camera, {0.4, 0.6, 2})).norm(), 1e-9);
}

TEST_P(CameraLaws, PointsBehindHaveNoImage) { EXPECT_FALSE(project(camera, {0, 0, -1})); }

// The polynomial of a lens of measured coordinates, taken as it stands in the report of another program, in mm: focal
// length 7.457 mm, a pixel of 0.0032 mm, y upwards, image coordinates from the principal point.
TEST(Camera, CorrectsMeasuredCoordinatesInMillimetres) {
  const double c = 7.457, pixel = 0.0032, k1 = 4.6e-3, k2 = -4.5e-5, k3 = -2e-6, p1 = -6.1e-5, p2 = -4.4e-5;
  Camera camera = ideal_camera(c / pixel, 2272, 1704);
  camera.model = CameraModel::kBrownOfMeasured;
  camera.params[Camera::kK1] = k1 * c * c;
  camera.params[Camera::kK2] = k2 * c * c * c * c;
  camera.params[Camera::kK3] = k3 * c * c * c * c * c * c;
  camera.params[Camera::kP1] = p1 * c;
  camera.params[Camera::kP2] = -p2 * c;  // y is turned round
  const double x = 2.9, y = -1.7, r2 = x * x + y * y;  // mm
  const double radial = r2 * (k1 + r2 * (k2 + r2 * k3));
  const double x_corrected = x + x * radial + p1 * (r2 + 2 * x * x) + 2 * p2 * x * y;
  const double y_corrected = y + y * radial + p2 * (r2 + 2 * y * y) + 2 * p1 * x * y;
  const Eigen::Vector2d measured(1136 + x / pixel, 852 - y / pixel);
  EXPECT_LT((normalized(camera, measured) - Eigen::Vector2d(x_corrected, -y_corrected) / c).norm(), 1e-14);
  const auto pixel_of = project(camera, {x_corrected, -y_corrected, c});
  ASSERT_TRUE(pixel_of);
  EXPECT_LT((*pixel_of - measured).norm(), 1e-9);
}

TEST(Camera, CorrectionsBeyondTheFoldHaveNoImage) {
  Camera camera = ideal_camera(1000, 1000, 1000);
  camera.model = CameraModel::kBrownOfMeasured;
  camera.params[Camera::kK1] = -0.3;  // grows until r = 1/sqrt(0.9), to 2/3 of that
  EXPECT_TRUE(project(camera, {0.6, 0, 1}));
  EXPECT_TRUE(project(camera, {0.70, 0, 1}));
  EXPECT_FALSE(project(camera, {0.71, 0, 1}));
  EXPECT_FALSE(project(camera, {5, 5, 1}));
}

TEST(Camera, PointsBeyondTheFoldHaveNoImage) {
  Camera camera = ideal_camera(1000, 1000, 1000);
  camera.params[Camera::kK1] = -0.3;  // grows until r = 1/sqrt(0.9)
  EXPECT_TRUE(project(camera, {1.0, 0, 1}));
  EXPECT_FALSE(project(camera, {1.1, 0, 1}));
  EXPECT_FALSE(project(camera, {5, 5, 1}));
}

TEST_P(CameraLaws, NormalizedUndoesProject) {
  for (double column = 0; column <= 1200; column += 75)
    for (double row = 0; row <= 900; row += 75) {
      const auto back = project(camera, normalized(camera, {column, row}).homogeneous());
      ASSERT_TRUE(back);
      EXPECT_LT((*back - Eigen::Vector2d(column, row)).norm(), 1e-8);
    }
}

// Central differences of step h have error h^2/6 times the third derivative plus rounding 1e-16/h: 1e-6 relative is
// safe.
TEST_P(CameraLaws, DerivativesAgreeWithNumericOnes) {
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
