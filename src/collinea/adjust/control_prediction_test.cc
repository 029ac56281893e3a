// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/control_prediction.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "collinea/adjust/test_block.h"

namespace collinea {
namespace {

using testing::test_block;

AdjustOptions with_covariances() {
  return {.calibration = "focal", .loss = "none", .position_loss = "none", .covariances = true};
}

/// Mean over independent blocks and its standard deviation, from their own spread: points of one block are correlated.
struct Series {
  double sum = 0, squares = 0;
  int blocks = 0;
  void add(double of_block) { sum += of_block, squares += of_block * of_block, ++blocks; }
  [[nodiscard]] double mean() const { return sum / blocks; }
  [[nodiscard]] double sigma_of_mean() const { return std::sqrt((squares / blocks - mean() * mean()) / blocks); }
};

// e' C^-1 e of a check point is chi-squared with 3 degrees of freedom: mean 3. Differences of control points in their
// predicted sigmas have mean square 1, and of all differences 0.27 % lie beyond three sigmas. Bounds: four standard
// deviations of the mean of 600 blocks.
TEST(ControlPrediction, CheckPointErrorsAreAsLongAsPredicted) {
  Series of_checks, of_control, beyond;
  constexpr int kBlocks = 600;
  for (int seed = 1; seed <= kBlocks; ++seed) {
    const Block block = test_block({.rows = 2,
                                    .columns = 3,
                                    .points = 50,
                                    .sigma_px = 0.5,
                                    .control = 12,
                                    .control_sigma_m = 0.01,
                                    .seed = static_cast<std::uint64_t>(seed)});
    const auto adjusted = adjust(block, {}, with_covariances(), {});
    ASSERT_TRUE(adjusted) << adjusted.error().message;
    double of_block = 0, residuals = 0, axes = 0, far = 0;
    int checks = 0, used = 0;
    for (const ControlDifference& control : adjusted->control) {
      if (!control.covariance_m2) continue;
      for (int axis = 0; axis < 3; ++axis) {
        ++axes;
        far += std::abs(control.difference_m[axis]) > 3 * control.difference_sigma_m[axis];
      }
      if (control.used) {
        residuals += (control.difference_m.array() / control.difference_sigma_m.array()).square().mean();
        ++used;
        continue;
      }
      const Eigen::Matrix3d survey = 1e-4 * Eigen::Matrix3d::Identity();
      of_block += control.difference_m.dot((*control.covariance_m2 + survey).inverse() * control.difference_m);
      ++checks;
    }
    ASSERT_GE(checks, 2);
    of_checks.add(of_block / checks);
    of_control.add(residuals / used);
    beyond.add(far / axes);
  }
  EXPECT_NEAR(of_checks.mean(), 3, 4 * of_checks.sigma_of_mean());
  EXPECT_LT(4 * of_checks.sigma_of_mean(), 0.3);
  EXPECT_NEAR(of_control.mean(), 1, 4 * of_control.sigma_of_mean());
  EXPECT_LT(4 * of_control.sigma_of_mean(), 0.1);
  EXPECT_NEAR(beyond.mean(), 0.0027, 4 * beyond.sigma_of_mean());
}

// A check point with its rays as a tie point, whose measurements weigh nothing: the same covariance as the inverse of
// the full normal equations gives the tie point.
TEST(ControlPrediction, CheckPointsHaveTheCovarianceOfAPointThatDoesNotPull) {
  const Block block = test_block({.rows = 2, .columns = 3, .points = 50, .sigma_px = 0.5, .control = 9});
  const auto as_check = adjust(block, {}, with_covariances(), {});
  ASSERT_TRUE(as_check);
  Block other = block;
  for (auto& [id, control] : other.control)
    if (control.role == ControlRole::kCheck) {
      control.role = ControlRole::kControl;
      control.sigma_m.setConstant(std::numeric_limits<double>::infinity());
    }
  const auto as_tie = adjust(other, {}, with_covariances(), {});
  ASSERT_TRUE(as_tie);
  for (std::size_t i = 0; i < as_check->control.size(); ++i) {
    const ControlDifference &check = as_check->control[i], &tie = as_tie->control[i];
    if (check.used || !check.covariance_m2) continue;
    ASSERT_TRUE(tie.covariance_m2);
    // Its measurements, now in the block, can only help, and one point of sixty helps little.
    EXPECT_LE(tie.covariance_m2->trace(), check.covariance_m2->trace() * (1 + 1e-9));
    EXPECT_GT(tie.covariance_m2->trace(), 0.5 * check.covariance_m2->trace());
  }
}

TEST(ControlPrediction, APointThatIsNotSurveyedOnAnAxisHasNoExpectedDifferenceThere) {
  Block block = test_block({.rows = 2, .columns = 3, .points = 50, .sigma_px = 0.5, .control = 9});
  for (auto& [id, control] : block.control)
    if (id.value == 0) control.sigma_m.z() = std::numeric_limits<double>::infinity();
  const auto adjusted = adjust(block, {}, with_covariances(), {});
  ASSERT_TRUE(adjusted);
  const ControlDifference& height_free = adjusted->control.front();
  EXPECT_TRUE(std::isfinite(height_free.difference_sigma_m.x()));
  EXPECT_TRUE(std::isnan(height_free.difference_sigma_m.z()));
  EXPECT_GT((*height_free.covariance_m2)(2, 2), 0);
}

}  // namespace
}  // namespace collinea
