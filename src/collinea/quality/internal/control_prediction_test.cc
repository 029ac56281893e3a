// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/internal/control_prediction.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <array>
#include <cmath>

#include "collinea/quality/internal/test_examine.h"

namespace collinea {
namespace {

using testing::test_block;

ExamineOptions with_covariances() {
  return {.adjust = {.calibration = Calibration::kFocal, .loss = Loss::kNone, .position_loss = Loss::kNone}};
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
    const auto adjusted = examine(block, {}, with_covariances(), {});
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

// Image sigmas that are wrong by a factor, of a survey that is as good as stated: check points, control and control
// left out differ nearly as much as is stated; were the survey multiplied too, the mean of squares would be 4 or 1/4.
// The position of the block, which comes from control, is multiplied with the rest: a tenth of the survey's variance
// with 24 points, four tenths when sigma0 is 2. With true sigmas four deviations of the mean of 60 blocks, by their
// scatter.
TEST(ControlPrediction, WrongImageSigmasDoNotChangeWhatTheSurveyIsWorth) {
  for (const double wrong : {0.5, 1.0, 2.0}) {
    std::array<double, 4> sum{}, squares{};  // check, control, left out, tests of control
    constexpr int kBlocks = 60;
    for (std::uint64_t seed = 1; seed <= kBlocks; ++seed) {
      Block block = test_block({.rows = 2,
                                .columns = 3,
                                .points = 50,
                                .sigma_px = 0.5,
                                .control = 36,
                                .control_sigma_m = 0.05,
                                .seed = seed});
      for (Observation& seen : block.observations) seen.sigma_px *= wrong;
      for (ControlObservation& seen : block.control_observations) seen.sigma_px *= wrong;
      ExamineOptions options = with_covariances();
      options.reliability = true;
      const auto adjusted = examine(block, {}, options, {});
      ASSERT_TRUE(adjusted && adjusted->reliability);
      std::array<double, 4> of_block{}, count{};
      const auto add = [&](std::size_t kind, const Eigen::Vector3d& difference, const Eigen::Vector3d& sigma) {
        of_block[kind] += (difference.array() / sigma.array()).square().mean();
        ++count[kind];
      };
      for (const ControlDifference& control : adjusted->control)
        if (control.covariance_m2) add(control.used, control.difference_m, control.difference_sigma_m);
      for (const LeftOutPoint& point : adjusted->reliability->left_out)
        add(2, point.difference_m, point.difference_sigma_m);
      for (const TestedObservation& one : adjusted->reliability->others)
        if (one.group == ObservationGroup::kControlPlan || one.group == ObservationGroup::kControlHeight)
          add(3, Eigen::Vector3d::Constant(one.w), Eigen::Vector3d::Ones());
      for (std::size_t kind = 0; kind < 4; ++kind) {
        const double mean = of_block[kind] / count[kind];
        sum[kind] += mean, squares[kind] += mean * mean;
      }
    }
    for (std::size_t kind = 0; kind < 4; ++kind) {
      const double mean = sum[kind] / kBlocks, sigma = std::sqrt((squares[kind] / kBlocks - mean * mean) / kBlocks);
      EXPECT_NEAR(mean, 1, wrong == 1 ? 4 * sigma + 0.02 : 0.4) << wrong << " " << kind;
      EXPECT_LT(4 * sigma, 0.2);
    }
  }
}

// A check point as a tie point whose measurements weigh less and less: its covariance tends to s^2 V + P, V that of its
// own rays at s = 1 and P what the images make of it. Two values of s tell V, and V + P is the covariance of the check
// point. What the point still pulls is of the order 1 / s^2.
TEST(ControlPrediction, CheckPointsHaveTheCovarianceOfAPointThatDoesNotPull) {
  const Block block = test_block({.rows = 2, .columns = 3, .points = 50, .control = 9});
  const auto as_check = examine(block, {}, with_covariances(), {});
  ASSERT_TRUE(as_check);
  const auto as_tie = [&](double s) {
    Block other = block;
    for (auto& [id, control] : other.control)
      if (control.role == ControlRole::kCheck) {
        control.role = ControlRole::kControl;
        control.sigma_m.setConstant(std::numeric_limits<double>::infinity());
      }
    for (ControlObservation& seen : other.control_observations)
      if (block.control.at(seen.point).role == ControlRole::kCheck) seen.sigma_px *= s;
    return examine(other, {}, with_covariances(), {});
  };
  constexpr double kWeak = 100;
  const auto weak = as_tie(kWeak), weaker = as_tie(2 * kWeak);
  ASSERT_TRUE(weak && weaker);
  int compared = 0;
  for (std::size_t i = 0; i < as_check->control.size(); ++i) {
    if (as_check->control[i].used || !as_check->control[i].covariance_m2) continue;
    const Eigen::Matrix3d &once = *weak->control[i].covariance_m2, &twice = *weaker->control[i].covariance_m2;
    const Eigen::Matrix3d own = (twice - once) / (3 * kWeak * kWeak);
    const Eigen::Matrix3d expected = once - (kWeak * kWeak - 1) * own;
    EXPECT_LT((*as_check->control[i].covariance_m2 - expected).norm(), 2e-3 * expected.norm());
    EXPECT_GT(expected.trace(), 1.2 * own.trace());  // the images do count
    ++compared;
  }
  EXPECT_GE(compared, 2);
}

// A check point whose rays take part is a point of control without coordinates, but for its name.
TEST(ControlPrediction, RaysOfCheckPointsTakePartAsThoseOfPointsWithoutCoordinates) {
  const Block block = test_block({.rows = 2, .columns = 3, .points = 50, .sigma_px = 0.5, .control = 9});
  Block free = block;
  for (auto& [id, control] : free.control)
    if (control.role == ControlRole::kCheck) {
      control.role = ControlRole::kControl;
      control.sigma_m.setConstant(std::numeric_limits<double>::infinity());
    }
  const auto with = examine(block, {.use_check_rays = true}, with_covariances(), {});
  const auto as_control = examine(free, {}, with_covariances(), {}),
             without = examine(block, {}, with_covariances(), {});
  ASSERT_TRUE(with && as_control && without);
  EXPECT_EQ(with->redundancy, as_control->redundancy);
  EXPECT_GT(with->redundancy, without->redundancy);
  EXPECT_EQ(with->sigma0, as_control->sigma0);
  ASSERT_EQ(with->control.size(), as_control->control.size());
  int checks = 0;
  for (std::size_t i = 0; i < with->control.size(); ++i) {
    const ControlDifference &one = with->control[i], &same = as_control->control[i];
    EXPECT_EQ(*one.position_in_world, *same.position_in_world);
    if (block.control.at(one.point).role != ControlRole::kCheck) continue;
    EXPECT_FALSE(one.used);
    EXPECT_EQ(*one.covariance_m2, *same.covariance_m2);
    EXPECT_LT(one.covariance_m2->trace(), without->control[i].covariance_m2->trace());
    const double sigma =
        std::hypot(sigma_scale(*with) * std::sqrt((*one.covariance_m2)(2, 2)), block.control.at(one.point).sigma_m.z());
    EXPECT_NEAR(one.difference_sigma_m.z(), sigma, 1e-12);
    ++checks;
  }
  EXPECT_GE(checks, 2);
}

// As above, of check points whose rays take part: the mean of e' C^-1 e is 3.
TEST(ControlPrediction, CheckPointsWhoseRaysTakePartDifferAsPredicted) {
  Series of_checks;
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    const Block block = test_block(
        {.rows = 2, .columns = 3, .points = 50, .sigma_px = 0.5, .control = 12, .control_sigma_m = 0.01, .seed = seed});
    const auto adjusted = examine(block, {.use_check_rays = true}, with_covariances(), {});
    ASSERT_TRUE(adjusted) << adjusted.error().message;
    double of_block = 0;
    int checks = 0;
    for (const ControlDifference& one : adjusted->control) {
      if (one.used || !one.covariance_m2) continue;
      const Eigen::Matrix3d survey = 1e-4 * Eigen::Matrix3d::Identity();
      of_block += one.difference_m.dot((*one.covariance_m2 + survey).inverse() * one.difference_m);
      ++checks;
    }
    ASSERT_GE(checks, 2);
    of_checks.add(of_block / checks);
  }
  EXPECT_NEAR(of_checks.mean(), 3, 4 * of_checks.sigma_of_mean());
  EXPECT_LT(4 * of_checks.sigma_of_mean(), 0.4);
}

TEST(ControlPrediction, APointThatIsNotSurveyedOnAnAxisHasNoExpectedDifferenceThere) {
  Block block = test_block({.rows = 2, .columns = 3, .points = 50, .sigma_px = 0.5, .control = 9});
  for (auto& [id, control] : block.control)
    if (id.value == 0) control.sigma_m.z() = std::numeric_limits<double>::infinity();
  const auto adjusted = examine(block, {}, with_covariances(), {});
  ASSERT_TRUE(adjusted);
  const ControlDifference& height_free = adjusted->control.front();
  EXPECT_TRUE(std::isfinite(height_free.difference_sigma_m.x()));
  EXPECT_TRUE(std::isnan(height_free.difference_sigma_m.z()));
  EXPECT_GT((*height_free.covariance_m2)(2, 2), 0);
}

}  // namespace
}  // namespace collinea
