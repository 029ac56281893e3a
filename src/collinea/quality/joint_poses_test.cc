// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/joint_poses.h"

#include <gtest/gtest.h>

#include "collinea/quality/internal/test_examine.h"

namespace collinea {
namespace {

using testing::test_block;

struct Adjusted {
  Block block;
  AdjustScope scope;
  Examined examined;
};

Adjusted adjusted_block(Calibration calibration) {
  Adjusted all{test_block({.points = 120, .sigma_px = 0.5, .position_sigma_m = 0.05, .seed = 4}), {}, {}};
  all.scope = with_first_cameras({}, all.block.cameras);
  auto examined = examine(all.block, all.scope, testing::examined(calibration), {});
  EXPECT_TRUE(examined);
  apply(*examined, all.block);
  all.examined = *std::move(examined);
  return all;
}

// The factor is that of the same equations, linearised a step of the last iteration away.
TEST(BlockPrecision, IsThatOfTheAdjustment) {
  for (const Calibration calibration : {Calibration::kNone, Calibration::kFocalRadial}) {
    const Adjusted all = adjusted_block(calibration);
    auto precision = BlockPrecision::of(all.block, all.scope, testing::plain(calibration), {});
    ASSERT_TRUE(precision) << precision.error().message;
    std::vector<ImageId> images;
    for (const OrientedImage& one : oriented_images(all.block)) images.push_back(one.image);
    const auto joint = precision->joint_poses(images);
    ASSERT_TRUE(joint);
    for (std::size_t i = 0; i < images.size(); ++i) {
      const auto at = 6 * Eigen::Index(i);
      const Matrix6d& expected = all.examined.pose_covariance.at(images[i]);
      const Eigen::Matrix<double, 6, 1> sigma = expected.diagonal().cwiseSqrt();
      const Matrix6d difference = joint->covariance.block<6, 6>(at, at) - expected;
      EXPECT_LT(
          (sigma.cwiseInverse().asDiagonal() * difference * sigma.cwiseInverse().asDiagonal()).cwiseAbs().maxCoeff(),
          1e-6);
    }
    EXPECT_EQ(joint->cameras.size(), calibration == Calibration::kNone ? 0u : 1u);
    auto row = 6 * Eigen::Index(images.size());
    for (const JointPoses::FreeCamera& camera : joint->cameras)
      for (const int param : camera.params) {
        const double expected = all.examined.camera_covariance.at(camera.camera)(param, param);
        EXPECT_NEAR(joint->covariance(row, row), expected, 1e-6 * expected);
        ++row;
      }
    EXPECT_EQ(row, joint->covariance.rows());
    // Some of them, in another order, are a part of it.
    const std::vector<ImageId> two{images.back(), images.front()};
    const auto some = precision->joint_poses(two);
    ASSERT_TRUE(some);
    const auto last = 6 * Eigen::Index(images.size() - 1);
    EXPECT_TRUE((some->covariance.block<6, 6>(0, 6)).isApprox((joint->covariance.block<6, 6>(last, 0)), 1e-9));
    EXPECT_GT((joint->covariance.block<6, 6>(last, 0).norm()), 0);
  }
}

TEST(BlockPrecision, WhatNothingFixesHasNone) {
  const Block free = test_block({.points = 120, .sigma_px = 0.5, .seed = 4});
  const auto precision = BlockPrecision::of(free, {}, testing::plain(), {});
  ASSERT_FALSE(precision);
  EXPECT_EQ(precision.error().code, Errc::kUnsupported);
  Adjusted all = adjusted_block(Calibration::kNone);
  auto known = BlockPrecision::of(all.block, all.scope, testing::plain(), {});
  ASSERT_TRUE(known);
  EXPECT_FALSE(known->joint_poses(std::vector{ImageId{9999}}));
}

}  // namespace
}  // namespace collinea
