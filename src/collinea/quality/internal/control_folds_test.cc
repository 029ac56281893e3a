// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/internal/control_folds.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "collinea/quality/internal/test_examine.h"

namespace collinea {
namespace {

using testing::test_block;

const Run kRun;

ExamineOptions tested(int folds) {
  ExamineOptions options{
      .adjust = {.calibration = Calibration::kFocalRadial, .loss = Loss::kNone, .position_loss = Loss::kNone},
      .reliability = true};
  options.adjust.relative_cost_change = options.adjust.parameter_change = 1e-13;
  options.adjust.step_sigmas = 0;
  options.test.folds = folds;
  return options;
}

Block block_of(std::uint64_t seed, int control = 12) {
  return test_block({.rows = 2,
                     .columns = 3,
                     .points = 60,
                     .sigma_px = 0.5,
                     .position_sigma_m = 0.05,
                     .control = control,
                     .seed = seed});
}

// Against adjustments in which the coordinates of a part really take no part; also with points that a measurement
// joins.
TEST(ControlFolds, LeavingAPartOutIsWhatReadjustingWithoutItSays) {
  for (const bool first_retained : {false, true}) {
    Block block = block_of(3);
    if (first_retained) block.geodetic.push_back({.from = {0}, .to = {4}, .value = 10, .sigma = 1e6});
    const auto with = examine(block, {}, tested(3), kRun);
    ASSERT_TRUE(with && with->reliability);
    const Folded& folded = with->reliability->folded;
    ASSERT_EQ(folded.folds, 3);
    ASSERT_EQ(folded.points.size(), 8u);  // every third of twelve is a check point
    ASSERT_EQ(folded.part.size(), 8u);
    for (int part = 1; part <= 3; ++part) {
      Block other = block;
      for (std::size_t i = 0; i < folded.points.size(); ++i)
        if (folded.part[i] == part)
          other.control.at(folded.points[i].point).sigma_m.setConstant(std::numeric_limits<double>::infinity());
      const auto without = examine(other, {}, tested(3), kRun);
      ASSERT_TRUE(without && without->reliability);
      std::map<ControlId, ControlDifference> found;
      for (const ControlDifference& one : without->control) found[one.point] = one;
      for (std::size_t i = 0; i < folded.points.size(); ++i) {
        if (folded.part[i] != part) continue;
        const LeftOutPoint& one = folded.points[i];
        const ControlDifference& again = found.at(one.point);
        const Eigen::Vector3d off = *again.position_in_world - block.control.at(one.point).position_in_world;
        for (int axis = 0; axis < 3; ++axis) {
          // The equations are not quite linear.
          EXPECT_NEAR(one.difference_m[axis], off[axis], 0.02 * one.difference_sigma_m[axis]);
          const double expected = std::sqrt((*again.covariance_m2)(axis, axis) * std::pow(with->sigma0, 2) + 1e-4);
          EXPECT_NEAR(one.difference_sigma_m[axis], expected, 0.02 * expected);
        }
      }
    }
  }
}

TEST(ControlFolds, PartsHaveTwoPointsAndMore) {
  for (const auto& [control, folds, expected] :
       {std::tuple(3, 5, 0), std::tuple(6, 5, 2), std::tuple(12, 5, 4), std::tuple(12, 2, 2), std::tuple(24, 5, 5)}) {
    const auto adjusted = examine(block_of(5, control), {}, tested(folds), kRun);
    ASSERT_TRUE(adjusted && adjusted->reliability);
    const Folded& folded = adjusted->reliability->folded;
    EXPECT_EQ(folded.folds, expected) << control;
    std::map<int, int> members;
    for (const int part : folded.part) ++members[part];
    EXPECT_EQ(static_cast<int>(members.size()), expected);
    for (const auto& [part, count] : members) EXPECT_GE(count, 2);
  }
}

// Differences of parts that were left out are as large as their sigmas predict: their squares over them are 1 on
// average, within four deviations of the means of 60 blocks.
TEST(ControlFolds, DifferencesAreAsPredicted) {
  double sum = 0, squares = 0;
  constexpr int kBlocks = 60;
  for (std::uint64_t seed = 1; seed <= kBlocks; ++seed) {
    const auto adjusted = examine(block_of(100 + seed), {}, tested(4), kRun);
    ASSERT_TRUE(adjusted && adjusted->reliability);
    double of_block = 0, count = 0;
    for (const LeftOutPoint& one : adjusted->reliability->folded.points) {
      of_block += one.difference_m.cwiseQuotient(one.difference_sigma_m).squaredNorm();
      count += 3;
    }
    ASSERT_GT(count, 0);
    sum += of_block / count;
    squares += std::pow(of_block / count, 2);
  }
  const double mean = sum / kBlocks, deviation = std::sqrt((squares / kBlocks - mean * mean) / kBlocks);
  EXPECT_NEAR(mean, 1, 4 * deviation);
  EXPECT_LT(4 * deviation, 0.25);
}

TEST(ControlFolds, RootMeanSquaresLeaveOutWhatWasNotSurveyed) {
  const double nan = std::nan("");
  const std::vector<LeftOutPoint> points = {{{1}, {3, 4, 1}, {1, 1, 2}}, {{2}, {nan, nan, 7}, {nan, nan, 2}}};
  const LeftOutRms plan = rms_of(points, false), height = rms_of(points, true);
  EXPECT_EQ(plan.points, 1);
  EXPECT_DOUBLE_EQ(plan.difference_m, 5);
  EXPECT_DOUBLE_EQ(plan.predicted_m, std::sqrt(2));
  EXPECT_EQ(height.points, 2);
  EXPECT_DOUBLE_EQ(height.difference_m, 5);
  EXPECT_DOUBLE_EQ(height.predicted_m, 2);
}

}  // namespace
}  // namespace collinea
