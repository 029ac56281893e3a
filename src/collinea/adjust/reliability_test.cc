// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/reliability.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "collinea/adjust/bundle.h"
#include "collinea/adjust/quantiles.h"
#include "collinea/adjust/test_block.h"

namespace collinea {
namespace {

using testing::test_block;

AdjustOptions tested() {
  AdjustOptions options{.calibration = "focal_radial", .loss = "none", .position_loss = "none", .reliability = true};
  options.relative_cost_change = 1e-13;
  options.parameter_change = 1e-13;
  options.step_sigmas = 0;
  return options;
}

testing::TestBlockOptions small(std::uint64_t seed = 1) {
  return {.rows = 2, .columns = 3, .points = 60, .sigma_px = 0.5, .position_sigma_m = 0.05, .control = 9, .seed = seed};
}

Adjusted adjusted_of(const Block& block, const AdjustOptions& options, const AdjustScope& scope = {}) {
  auto adjusted = adjust(block, scope, options, {});
  EXPECT_TRUE(adjusted && adjusted->reliability) << (adjusted ? adjusted->undetermined : adjusted.error().message);
  return std::move(*adjusted);
}

TEST(Quantiles, AreThoseOfTheTables) {
  EXPECT_NEAR(normal_limit(0.001), 3.2905267, 1e-6);
  EXPECT_NEAR(normal_limit(0.05), 1.9599640, 1e-6);
  // tau = sqrt(r) t / sqrt(r - 1 + t^2) with Student's t of r - 1 degrees: 2.262157 for 9, 12.7062 for 1.
  const auto by_student = [](double t, double r) { return std::sqrt(r) * t / std::sqrt(r - 1 + t * t); };
  EXPECT_NEAR(tau_limit(0.05, 10), by_student(2.2621572, 10), 1e-5);
  EXPECT_NEAR(tau_limit(0.05, 2), by_student(12.706205, 2), 1e-5);
  EXPECT_EQ(tau_limit(0.05, 1), 1);
  EXPECT_NEAR(tau_limit(0.001, 100000), normal_limit(0.001), 1e-3);
}

TEST(Reliability, RedundancyNumbersAddUpToTheRedundancy) {
  for (const bool robust : {false, true})
    for (const bool control : {true, false}) {
      AdjustOptions options = tested();
      if (robust) options.loss = "cauchy", options.position_loss = "huber";
      AdjustScope scope{.use_positions = control, .use_control = control};
      const Adjusted adjusted = adjusted_of(test_block(small()), options, scope);
      const Reliability& found = *adjusted.reliability;
      EXPECT_EQ(adjusted.rank_defect, control ? 0 : 7);
      EXPECT_NEAR(found.redundancy_sum, double(adjusted.redundancy), 1e-4);
      double ties = 0;
      for (const Eigen::Vector2d& r : found.tie_redundancy) {
        ties += r.sum();
        EXPECT_GT(r.minCoeff(), -1e-9);
        EXPECT_LT(r.maxCoeff(), 1);
      }
      EXPECT_NEAR(ties, found.groups[0].redundancy, 1e-6);
      EXPECT_EQ(found.tie_redundancy.size(), adjusted.observations.size());
    }
}

// By definition: a small blunder appears in its own residual with the factor r, and moves the adjusted value by 1 - r.
TEST(Reliability, ABlunderShowsInItsResidualByTheRedundancyNumber) {
  Block block = test_block(small(4));
  const Adjusted before = adjusted_of(block, tested());
  constexpr double kBlunder_px = 0.01;
  for (const std::size_t i : {3u, 40u, 91u}) {
    Block other = block;
    const std::uint32_t place = before.observations[i];
    other.observations[place].pixel.x() += kBlunder_px;
    const Adjusted after = adjusted_of(other, tested());
    EXPECT_NEAR((after.residuals_px[i].x() - before.residuals_px[i].x()) / kBlunder_px,
                before.reliability->tie_redundancy[i].x(), 2e-3);
  }
  for (const TestedObservation& one : before.reliability->others) {
    if (one.group != ObservationGroup::kControlHeight && one.group != ObservationGroup::kPositionPlan) continue;
    Block other = block;
    if (one.group == ObservationGroup::kControlHeight)
      other.control.at(ControlId{one.source}).position_in_world.z() += 1e-3;
    else
      other.images.at(ImageId{one.source}).position->position_in_world[one.axis] += 1e-3;
    const Adjusted after = adjusted_of(other, tested());
    const auto again = std::find_if(
        after.reliability->others.begin(), after.reliability->others.end(), [&](const TestedObservation& other_one) {
          return other_one.group == one.group && other_one.source == one.source && other_one.axis == one.axis;
        });
    ASSERT_NE(again, after.reliability->others.end());
    EXPECT_NEAR((again->residual - one.residual) / 1e-3, one.redundancy, 2e-3);
  }
}

// Good observations are rejected as often as stated. Those of a block are correlated, so their number scatters more
// than a binomial one: five of its deviations, over 40 blocks.
TEST(Reliability, FalseAlarmsAreAsOftenAsStated) {
  AdjustOptions options = tested();
  options.false_alarm = 0.01;
  for (const bool known : {true, false}) {
    options.sigma0_known = known;
    double tests = 0, rejected = 0;
    for (std::uint64_t seed = 1; seed <= 40; ++seed) {
      const Adjusted adjusted = adjusted_of(test_block(small(seed)), options);
      tests += double(adjusted.reliability->tested);
      rejected += double(adjusted.reliability->rejected);
    }
    EXPECT_NEAR(rejected / tests, 0.01, 5 * std::sqrt(0.01 * 0.99 / tests)) << tests;
  }
}

// A minimal detectable blunder is found with the stated power: 80 % of 100, four binomial deviations.
TEST(Reliability, MinimalDetectableBlundersAreFoundWithTheStatedPower) {
  AdjustOptions options = tested();
  options.sigma0_known = true;
  int found = 0, planted = 0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    const Block block = test_block(small(seed));
    const Adjusted clean = adjusted_of(block, options);
    Block other = block;
    const auto& all = clean.reliability->others;
    const auto height = std::find_if(all.begin(), all.end(), [](const TestedObservation& one) {
      return one.group == ObservationGroup::kControlHeight;
    });
    ASSERT_NE(height, all.end());
    other.control.at(ControlId{height->source}).position_in_world.z() += height->least_blunder;
    const Adjusted spoiled = adjusted_of(other, options);
    ++planted;
    for (const TestedObservation& one : spoiled.reliability->suspects)
      found += one.group == height->group && one.source == height->source && one.axis == 2;
  }
  EXPECT_NEAR(double(found) / planted, 0.8, 4 * std::sqrt(0.8 * 0.2 / planted));
}

TEST(Reliability, TheWorstSuspectIsThePlantedBlunder) {
  Block block = test_block(small(7));
  block.observations[50].pixel.y() += 12;
  const Adjusted adjusted = adjusted_of(block, tested());
  ASSERT_FALSE(adjusted.reliability->suspects.empty());
  const TestedObservation& worst = adjusted.reliability->suspects.front();
  EXPECT_EQ(worst.group, ObservationGroup::kTieImages);
  EXPECT_EQ(worst.source, 50u);
  EXPECT_NEAR(std::abs(worst.blunder), 12, 4 * 0.5 / std::sqrt(worst.redundancy));
}

// Against an adjustment where the coordinates of the point really take no part.
TEST(Reliability, LeavingAControlPointOutIsWhatReadjustingWithoutItSays) {
  const Block block = test_block(small(3));
  const Adjusted with = adjusted_of(block, tested());
  ASSERT_GE(with.reliability->left_out.size(), 4u);
  for (const LeftOutPoint& left_out : with.reliability->left_out) {
    Block other = block;
    other.control.at(left_out.point).sigma_m.setConstant(std::numeric_limits<double>::infinity());
    const Adjusted without = adjusted_of(other, tested());
    for (const ControlDifference& control : without.control)
      if (control.point == left_out.point)
        for (int axis = 0; axis < 3; ++axis) {
          const double off_m = (*control.position_in_world - block.control.at(control.point).position_in_world)[axis];
          EXPECT_NEAR(left_out.difference_m[axis], off_m, 0.02 * left_out.difference_sigma_m[axis]);
          const double expected = std::sqrt((*control.covariance_m2)(axis, axis) * with.sigma0 * with.sigma0 + 1e-4);
          EXPECT_NEAR(left_out.difference_sigma_m[axis], expected, 0.02 * expected);
        }
  }
}

}  // namespace
}  // namespace collinea
