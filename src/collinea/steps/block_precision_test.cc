// SPDX-License-Identifier: Apache-2.0
#include "collinea/project/block_precision.h"

#include <gtest/gtest.h>

#include "collinea/base/test_folder.h"
#include "collinea/project/adjustment_task.h"
#include "collinea/steps/flow.h"
#include "collinea/steps/test_project.h"

namespace collinea {
namespace {

// The largest difference of a variance or covariance of one image from what the adjustment wrote, in its sigmas.
double largest_difference(BlockPrecision& precision, const BlockCovariances& known) {
  double largest = 0;
  for (const auto& [image, covariance] : known.poses) {
    const auto joint = precision.joint_poses({&image, 1});
    EXPECT_TRUE(joint);
    if (!joint) return 1;
    const Matrix6d difference = joint->covariance.topLeftCorner<6, 6>() - covariance;
    const Eigen::Matrix<double, 6, 1> scale = covariance.diagonal().cwiseSqrt().cwiseInverse();
    largest = std::max(largest, (scale.asDiagonal() * difference * scale.asDiagonal()).cwiseAbs().maxCoeff());
  }
  return largest;
}

// The equations are set up again from the project as the step left it: with what it rejected, the sigmas that it found
// by variance components, positions, control and a camera that it calibrated, or with an undetermined camera held.
TEST(BlockPrecisionOfProject, IsThatOfItsAdjustment) {
  for (const double wrong_share : {0.0, 0.04})
    for (const int control_points : {0, 5}) {
      const TestFolder folder;
      SurveyOptions survey;
      survey.images = 12;
      survey.control_points = control_points;
      auto project = open_simulated(folder / "block", survey, {.points_per_image = 120, .wrong_share = wrong_share});
      ASSERT_TRUE(project) << project.error().message;
      const auto done = bring_up_to(*project, Step::kAdjust);
      ASSERT_TRUE(done) << done.error().message;
      const auto block = project->store.read_block();
      const auto known = project->store.read_covariances();
      ASSERT_TRUE(block && known && !known->poses.empty());
      auto precision = precision_of(project->folder, *block, *known);
      ASSERT_TRUE(precision) << precision.error().message;
      EXPECT_LT(largest_difference(*precision, *known), 0.01) << wrong_share << " " << control_points;
      // Not that of a block which is known otherwise.
      BlockCovariances others = *known;
      for (auto& [image, covariance] : others.poses) covariance *= 1.2;
      const auto refused = precision_of(project->folder, *block, others);
      ASSERT_FALSE(refused);
      EXPECT_EQ(refused.error().code, Errc::kUnsupported);
    }
}

TEST(BlockPrecisionOfProject, WhatIsNotAdjustedHasNone) {
  const TestFolder folder;
  SurveyOptions survey;
  survey.images = 8;
  survey.control_points = 0;
  survey.receiver.gps = false;
  auto project = open_simulated(folder / "block", survey, {.points_per_image = 120, .wrong_share = 0});
  ASSERT_TRUE(project) << project.error().message;
  ASSERT_TRUE(bring_up_to(*project, Step::kOrient));
  const auto oriented = precision_of(project->folder, *project->store.read_block(), {});
  ASSERT_FALSE(oriented);
  EXPECT_EQ(oriented.error().code, Errc::kNotFound) << oriented.error().message;
  // Nothing fixes it: the covariances of its images are of a datum that was chosen.
  ASSERT_TRUE(bring_up_to(*project, Step::kAdjust));
  const auto free = precision_of(project->folder, *project->store.read_block(), *project->store.read_covariances());
  ASSERT_FALSE(free);
  EXPECT_EQ(free.error().code, Errc::kUnsupported) << free.error().message;
}

}  // namespace
}  // namespace collinea
