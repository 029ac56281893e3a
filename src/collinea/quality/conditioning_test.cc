// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/conditioning.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "collinea/quality/internal/test_examine.h"

namespace collinea {
namespace {

using testing::test_block;

ExamineOptions with_covariances(Calibration calibration) {
  return {.adjust = {.calibration = calibration, .loss = Loss::kNone, .position_loss = Loss::kNone}};
}

// One image over fixed points: the normal equations are the inverse of its covariance.
TEST(Conditioning, IsThatOfTheNormalEquationsWithOnesOnTheDiagonal) {
  const Block block = test_block({.rows = 1, .columns = 2, .points = 60, .sigma_px = 0.5});
  AdjustScope scope{.use_control = false};
  for (const auto& [id, point] : block.points) scope.fixed_points.insert(id);
  scope.fixed_images.insert(ImageId{11});
  const auto adjusted = examine(block, scope, with_covariances(Calibration::kNone), {});
  ASSERT_TRUE(adjusted && !adjusted->undetermined);
  ASSERT_EQ(adjusted->cam_from_world.size(), 1u);
  const auto& [id, pose] = *adjusted->cam_from_world.begin();
  Matrix6d to_cam = Matrix6d::Identity();
  to_cam.topLeftCorner<3, 3>() = pose.rotation.toRotationMatrix();
  const Matrix6d normals = (to_cam * adjusted->pose_covariance.at(id) * to_cam.transpose()).inverse();
  const Eigen::Matrix<double, 6, 1> scale = normals.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<Matrix6d> eigen(scale.asDiagonal() * normals * scale.asDiagonal());
  EXPECT_NEAR(adjusted->conditioning.inflation * eigen.eigenvalues()[0], 1, 0.05);
  ASSERT_FALSE(adjusted->conditioning.mostly.empty());
  for (const UnknownShare& one : adjusted->conditioning.mostly) {
    EXPECT_EQ(one.unknown.kind, SubjectKind::kImage);
    EXPECT_EQ(one.unknown.id, Subject::kAll);
  }
}

// A lens over level ground: focal length and height make up the worst combination.
TEST(Conditioning, TheWorstCombinationIsNamed) {
  Block block = test_block({.rows = 3, .columns = 4, .points = 150, .relief_m = 0, .control = 9, .tilt_rad = 0});
  const auto sound = examine(block, {}, with_covariances(Calibration::kNone), {});
  const auto weak = examine(block, {}, with_covariances(Calibration::kBrown), {});
  ASSERT_TRUE(sound && weak);
  EXPECT_GT(weak->conditioning.inflation, 3 * sound->conditioning.inflation);
  const auto& mostly = weak->conditioning.mostly;
  EXPECT_TRUE(std::any_of(mostly.begin(), mostly.end(), [&](const UnknownShare& one) {
    return one.unknown.camera() == block.cameras.begin()->first && one.unknown.aspect == Aspect::kParameter;
  }));
  EXPECT_TRUE(std::is_sorted(mostly.begin(), mostly.end(), [](auto& a, auto& b) { return a.share > b.share; }));
}

}  // namespace
}  // namespace collinea
