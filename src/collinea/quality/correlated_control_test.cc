// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "collinea/adjust/test_block.h"
#include "collinea/block/survey_covariance.h"
#include "collinea/quality/internal/test_examine.h"

namespace collinea::testing {
namespace {

const Eigen::Vector3d kAlongAndAcross(0.03, 0.004, 0.01);  // [m]: as of a bearing and distance survey

// Control whose errors and standard deviations differ along the axes.
Block block_with_control(std::uint64_t seed) {
  Block block = test_block({.points = 120, .sigma_px = 0.5, .control = 12, .control_sigma_m = 1e-9, .seed = seed});
  Random random(seed, 3);
  for (auto& [id, point] : block.control) {
    point.sigma_m = kAlongAndAcross;
    point.position_in_world += kAlongAndAcross.cwiseProduct(normal3(random));
  }
  return block;
}

// The same block in a world turned about two axes: the errors of control are now correlated.
Block rotated(const Block& block, const Eigen::Matrix3d& rotation) {
  Block out = block;
  const Eigen::Quaterniond angle(rotation);
  for (auto [id, pose] : oriented_images(out)) {
    pose = {(pose.rotation * angle.conjugate()).normalized(), pose.translation};
    set_pose(out, id, pose);
  }
  for (auto& [id, point] : out.points) point.position_in_world = rotation * point.position_in_world;
  for (auto& [id, point] : out.control) {
    point.position_in_world = rotation * point.position_in_world;
    const Eigen::Matrix3d covariance = rotation * survey_covariance(point.sigma_m, {0, 0, 0}) * rotation.transpose();
    point.sigma_m = covariance.diagonal().cwiseSqrt();
    point.correlation = correlation_of(covariance);
  }
  return out;
}

ExamineOptions all_statistics() {
  ExamineOptions options = tested();
  options.point_covariances = true;
  return options;
}

TEST(CorrelatedControl, ATurnedWorldHasTheSameAdjustment) {
  const Eigen::Matrix3d rotation = rotation_by({0.1, -0.2, 0.7}).toRotationMatrix();
  const Block block = block_with_control(4);
  const auto plain = examine(block, {}, all_statistics(), {});
  const auto other = examine(rotated(block, rotation), {}, all_statistics(), {});
  ASSERT_TRUE(plain) << plain.error().message;
  ASSERT_TRUE(other) << other.error().message;
  EXPECT_NEAR(plain->sigma0, other->sigma0, 1e-9);
  EXPECT_NEAR(plain->reliability->redundancy_sum, other->reliability->redundancy_sum, 1e-6);
  for (const auto& [id, pose] : plain->cam_from_world)
    EXPECT_LT((rotation * centre_of(pose) - centre_of(other->cam_from_world.at(id))).norm(), 1e-8);
  const auto same = [&](const Eigen::Matrix3d& covariance, const Eigen::Matrix3d& in_rotated) {
    return (rotation * covariance * rotation.transpose() - in_rotated).norm() < 1e-7 * in_rotated.norm();
  };
  for (std::size_t i = 0; i < plain->control.size(); ++i) {
    const ControlDifference &one = plain->control[i], &its = other->control[i];
    EXPECT_LT((rotation * one.difference_m - its.difference_m).norm(), 1e-7);  // 1e-5 of their sigmas
    EXPECT_TRUE(same(*one.covariance_m2, *its.covariance_m2)) << i;
    // What is expected of the difference is the diagonal of a covariance that turns with the world.
    EXPECT_NEAR(one.difference_sigma_m.squaredNorm() / its.difference_sigma_m.squaredNorm(), 1, 1e-6) << i;
  }
  const Reliability &first = *plain->reliability, &second = *other->reliability;
  ASSERT_EQ(first.left_out.size(), second.left_out.size());
  for (std::size_t i = 0; i < first.left_out.size(); ++i) {
    EXPECT_LT((rotation * first.left_out[i].difference_m - second.left_out[i].difference_m).norm(), 1e-7);
    EXPECT_NEAR(
        first.left_out[i].difference_sigma_m.squaredNorm() / second.left_out[i].difference_sigma_m.squaredNorm(), 1,
        1e-6);
  }
  ASSERT_GE(first.folded.folds, 2);
  for (std::size_t i = 0; i < first.folded.points.size(); ++i)
    EXPECT_LT((rotation * first.folded.points[i].difference_m - second.folded.points[i].difference_m).norm(), 1e-7);
  const auto of_control = [](const Reliability& reliability, auto member) {
    return reliability.groups[std::size_t(ObservationGroup::kControlPlan)].*member +
           reliability.groups[std::size_t(ObservationGroup::kControlHeight)].*member;
  };
  EXPECT_NEAR(of_control(first, &GroupSums::squares), of_control(second, &GroupSums::squares), 1e-6);
  EXPECT_NEAR(of_control(first, &GroupSums::redundancy), of_control(second, &GroupSums::redundancy), 1e-6);
}

// A blunder along one axis of the survey's ellipse is found by the coordinate's test of the turned world too, because
// the other coordinates predict it; w is a standard normal number without one.
TEST(CorrelatedControl, TestsAreStandardNormal) {
  const Eigen::Matrix3d rotation = rotation_by({0, 0, 0.6}).toRotationMatrix();
  double squares = 0;
  int count = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    ExamineOptions options = tested();
    options.test.sigma0_known = true;
    const auto adjusted = examine(rotated(block_with_control(seed), rotation), {}, options, {});
    ASSERT_TRUE(adjusted) << adjusted.error().message;
    for (const TestedObservation& one : adjusted->reliability->others)
      if (one.group == ObservationGroup::kControlPlan && std::isfinite(one.w)) {
        squares += one.w * one.w;
        ++count;
      }
  }
  // The two tests of a point are correlated: as if half as many at the least.
  EXPECT_NEAR(squares / count, 1, 4 * std::sqrt(2 / (count / 2.0)));
}

TEST(CorrelatedControl, WhatIsNoCovarianceIsNamed) {
  Block block = block_with_control(1);
  block.control.at({0}).correlation = {0.9, 0.9, -0.9};
  const auto refused = examine(block, {}, all_statistics(), {});
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("gcp0"), std::string::npos);
}

}  // namespace
}  // namespace collinea::testing
