// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/internal/reliability.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "collinea/math/quantiles.h"
#include "collinea/quality/examine.h"
#include "collinea/quality/internal/test_examine.h"

namespace collinea {
namespace {

using testing::test_block;

ExamineOptions tested() {
  ExamineOptions options{
      .adjust = {.calibration = Calibration::kFocalRadial, .loss = Loss::kNone, .position_loss = Loss::kNone},
      .reliability = true};
  options.adjust.relative_cost_change = 1e-13;
  options.adjust.parameter_change = 1e-13;
  options.adjust.step_sigmas = 0;
  return options;
}

testing::TestBlockOptions small(std::uint64_t seed = 1) {
  return {.rows = 2, .columns = 3, .points = 60, .sigma_px = 0.5, .position_sigma_m = 0.05, .control = 9, .seed = seed};
}

Examined adjusted_of(const Block& block, const ExamineOptions& options, const AdjustScope& scope = {}) {
  auto adjusted = examine(block, scope, options, {});
  EXPECT_TRUE(adjusted && adjusted->reliability)
      << (adjusted ? "something is not determined" : adjusted.error().message);
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

TEST(Reliability, EveryLevelAndPowerThatCanBeAskedForHasAnAnswer) {
  const Block block = test_block(small());
  for (const double false_alarm : {1e-12, 0.001, 0.5})
    for (const double power : {0.5, 0.8, 0.999})
      for (const bool known : {true, false}) {
        ExamineOptions options = tested();
        options.test.false_alarm = false_alarm;
        options.test.power = power;
        options.test.sigma0_known = known;
        const Examined adjusted = adjusted_of(block, options);
        const Reliability& found = *adjusted.reliability;
        EXPECT_TRUE(std::isfinite(found.limit) && std::isfinite(found.delta0));
        if (power == 0.5) {
          EXPECT_DOUBLE_EQ(found.delta0, normal_limit(false_alarm));
        }
        // What is found half of the time lies on the limit.
        if (known) {
          EXPECT_EQ(found.delta0 > found.limit, power > 0.5);
        }
      }
}

TEST(Reliability, RedundancyNumbersAddUpToTheRedundancy) {
  for (const bool robust : {false, true})
    for (const bool control : {true, false}) {
      ExamineOptions options = tested();
      if (robust) options.adjust.loss = Loss::kCauchy, options.adjust.position_loss = Loss::kHuber;
      AdjustScope scope{.use_positions = control, .use_control = control};
      const Examined adjusted = adjusted_of(test_block(small()), options, scope);
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

// Attitudes take redundancy and squares of their own; none of them are those of the tie points.
TEST(Reliability, VerticalsHaveTheirPartOfTheRedundancy) {
  const Block block = test_block(small(2));
  Random random(2);
  AdjustScope scope;
  for (const auto& [id, pose] : oriented_images(block)) {
    const Eigen::Vector3d up = pose.rotation * Eigen::Vector3d::UnitZ();
    scope.verticals[id] = {(up + 0.02 * up.cross(testing::normal3(random))).normalized(), 0.002};  // ten times too good
  }
  const Examined without = adjusted_of(block, tested()), with = adjusted_of(block, tested(), scope);
  EXPECT_EQ(with.redundancy, without.redundancy + 12);
  EXPECT_NEAR(with.reliability->redundancy_sum, double(with.redundancy), 1e-4);
  EXPECT_NEAR(without.reliability->groups[0].sigma_factor(), 1, 0.15);
  EXPECT_NEAR(with.reliability->groups[0].sigma_factor(), 1, 0.15);
}

TEST(Reliability, FixedPointsTestTheirRaysToo) {
  const Block block = test_block(small(2));
  for (const Calibration calibration : {Calibration::kNone, Calibration::kFocal}) {
    ExamineOptions options = tested();
    options.adjust.calibration = calibration;
    AdjustScope scope{.use_positions = false, .use_control = false};
    for (const auto& [id, point] : block.points) scope.fixed_points.insert(id);
    const Examined adjusted = adjusted_of(block, options, scope);
    EXPECT_EQ(adjusted.rank_defect, 0);
    EXPECT_NEAR(adjusted.reliability->redundancy_sum, double(adjusted.redundancy), 1e-6);
  }
  // A long narrow block: most images share no tile of the factor, yet all see the one far point that is fixed.
  Block strip = test_block({.rows = 1, .columns = 40, .points = 600, .sigma_px = 0.5, .position_sigma_m = 0.05});
  const PointId far{1};
  strip.points[far].position_in_world = {300, 0, -20000};
  std::vector<Observation> rays;
  for (const auto& [id, pose] : oriented_images(strip)) {
    const auto pixel = project(strip.camera_of(id), pose * strip.points[far].position_in_world);
    ASSERT_TRUE(pixel);
    rays.push_back({id, far, 0, *pixel, 0.5});
  }
  strip.observations.insert(strip.observations.begin(), rays.begin(), rays.end());
  const Examined adjusted = adjusted_of(strip, tested(), {.fixed_points = {far}});
  EXPECT_NEAR(adjusted.reliability->redundancy_sum, double(adjusted.redundancy), 1e-4);
}

// By definition: a small blunder appears in its own residual with the factor r, and moves the adjusted value by 1 - r.
TEST(Reliability, AGrossErrorShowsInItsResidualByTheRedundancyNumber) {
  Block block = test_block(small(4));
  const Examined before = adjusted_of(block, tested());
  constexpr double kGrossError_px = 0.01;
  for (const std::size_t i : {3u, 40u, 91u}) {
    Block other = block;
    const std::uint32_t index = before.observations[i];
    other.observations[index].pixel.x() += kGrossError_px;
    const Examined after = adjusted_of(other, tested());
    EXPECT_NEAR((after.residuals_px[i].x() - before.residuals_px[i].x()) / kGrossError_px,
                before.reliability->tie_redundancy[i].x(), 2e-3);
  }
  for (const TestedObservation& one : before.reliability->others) {
    if (one.group != ObservationGroup::kControlHeight && one.group != ObservationGroup::kPositionPlan) continue;
    Block other = block;
    if (one.group == ObservationGroup::kControlHeight)
      other.control.at(ControlId{one.source}).position_in_world.z() += 1e-3;
    else
      other.images.at(ImageId{one.source}).position->position_in_world[one.axis] += 1e-3;
    const Examined after = adjusted_of(other, tested());
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
  ExamineOptions options = tested();
  options.test.false_alarm = 0.01;
  for (const bool known : {true, false}) {
    options.test.sigma0_known = known;
    double tests = 0, rejected = 0;
    for (std::uint64_t seed = 1; seed <= 40; ++seed) {
      const Examined adjusted = adjusted_of(test_block(small(seed)), options);
      tests += double(adjusted.reliability->tested);
      rejected += double(adjusted.reliability->rejected);
    }
    EXPECT_NEAR(rejected / tests, 0.01, 5 * std::sqrt(0.01 * 0.99 / tests)) << tests;
  }
}

// A minimal detectable blunder is found with the stated power, 80 %: one of every kind in each of 100 blocks, four
// binomial deviations for each kind and for all.
constexpr auto kGroupsHere =
    static_cast<std::size_t>(ObservationGroup::kDistance);  // nothing is measured on the ground

TEST(Reliability, MinimalDetectableGrossErrorsAreFoundWithTheStatedPower) {
  ExamineOptions options = tested();
  options.test.sigma0_known = true;
  using Group = ObservationGroup;
  std::array<int, kObservationGroups> found{};
  constexpr int kBlocks = 100;
  for (std::uint64_t seed = 1; seed <= kBlocks; ++seed) {
    const Block block = test_block(small(seed));
    const Examined clean = adjusted_of(block, options);
    const auto spoiled_by = [&](Group group, std::uint32_t source, int axis, double gross_error) {
      Block other = block;
      if (group == Group::kTieImages)
        other.observations[source].pixel[axis] += gross_error;
      else if (group == Group::kControlImages)
        other.control_observations[source].pixel[axis] += gross_error;
      else if (group == Group::kControlPlan || group == Group::kControlHeight)
        other.control.at(ControlId{source}).position_in_world[axis] += gross_error;
      else
        other.images.at(ImageId{source}).position->position_in_world[axis] += gross_error;
      const Examined spoiled = adjusted_of(other, options);
      for (const TestedObservation& one : spoiled.reliability->suspects)
        found[static_cast<std::size_t>(group)] += one.group == group && one.source == source && one.axis == axis;
    };
    const std::size_t tie = seed % clean.observations.size();
    spoiled_by(Group::kTieImages, clean.observations[tie], 0,
               clean.reliability->delta0 * 0.5 / std::sqrt(clean.reliability->tie_redundancy[tie].x()));
    const auto& all = clean.reliability->others;
    for (std::size_t g = 1; g < kGroupsHere; ++g) {
      const auto one =
          std::find_if(all.begin(), all.end(), [&](const auto& other) { return std::size_t(other.group) == g; });
      ASSERT_NE(one, all.end());
      spoiled_by(one->group, one->source, one->axis, one->minimal_detectable_bias);
    }
  }
  int sum = 0;
  for (std::size_t g = 0; g < kGroupsHere; ++g) {
    EXPECT_NEAR(found[g] / double(kBlocks), 0.8, 4 * std::sqrt(0.8 * 0.2 / kBlocks)) << "group " << g;
    sum += found[g];
  }
  constexpr double kAll = double(kBlocks) * kGroupsHere;
  EXPECT_NEAR(sum / kAll, 0.8, 4 * std::sqrt(0.8 * 0.2 / kAll));
}

// What holds without a loss holds with one: errors that are normal with the given sigmas, under losses that set in
// early. Over 150 blocks, by their own scatter: sigma0 is 1, tests reject as often as stated, every group's squares are
// what its redundancy says, and the errors of poses are as long as their covariance says. Cauchy's weights fall with
// the residual from its start, and residuals of a point that a ray itself pulls are not normal: its variances come out
// up to 7 % too small for tie points and 20 % for positions (less with more rays a point), tests reject a fifth less.
TEST(Reliability, IsTrueUnderRobustLosses) {
  for (const Loss::Kind loss : {Loss::kHuber, Loss::kCauchy}) {
    ExamineOptions options = tested();
    options.adjust.loss = options.adjust.position_loss = loss;
    options.test.false_alarm = 0.01;
    constexpr int kBlocks = 150;
    constexpr std::size_t kSigma0 = kObservationGroups, kLevel = kSigma0 + 1, kPose = kLevel + 1, kAll = kPose + 1;
    std::array<double, kAll> sum{}, squares{};
    for (std::uint64_t seed = 1; seed <= kBlocks; ++seed) {
      const Block truth = test_block({.rows = 2, .columns = 3, .points = 80, .seed = seed});
      AdjustScope scope;
      const Block block = testing::measured_anew(truth, scope, seed);
      const Examined adjusted = adjusted_of(block, options, scope);
      std::array<double, kAll> of_block{};
      for (std::size_t g = 0; g < kObservationGroups; ++g)
        if (const GroupSums& group = adjusted.reliability->groups[g]; group.observations > 0)
          of_block[g] = group.squares / group.redundancy;
      of_block[kSigma0] = adjusted.sigma0 * adjusted.sigma0;
      of_block[kLevel] = double(adjusted.reliability->rejected) / double(adjusted.reliability->tested) / 0.01;
      for (const auto& [id, pose] : adjusted.cam_from_world) {
        const Rigid3& exact = pose_of(truth, id);
        Eigen::Matrix<double, 6, 1> error;
        error << rotation_vector(pose.rotation.conjugate() * exact.rotation), centre_of(exact) - centre_of(pose);
        of_block[kPose] += error.dot(adjusted.pose_covariance.at(id).inverse() * error) / 6 /
                           double(adjusted.cam_from_world.size()) / std::pow(adjusted.sigma0, 2);
      }
      for (std::size_t i = 0; i < kAll; ++i) sum[i] += of_block[i], squares[i] += of_block[i] * of_block[i];
    }
    for (const std::size_t i : {std::size_t{0}, std::size_t(ObservationGroup::kPositionPlan),
                                std::size_t(ObservationGroup::kPositionHeight), kSigma0, kLevel, kPose}) {
      const double mean = sum[i] / kBlocks, sigma = std::sqrt((squares[i] / kBlocks - mean * mean) / kBlocks);
      const bool falls = loss == Loss::kCauchy && i != kPose;
      // Beside chance what is stated above, with a tenth of it: 2 % of variances under Huber's loss (1 % of sigma0), 8
      // % of tie points and 20 % of positions and of the level under Cauchy's; and never more than one.
      const double influence = !falls ? 0.02 : i == 0 || i == kSigma0 ? 0.09 : 0.22;
      EXPECT_LT(mean, 1 + 4 * sigma + 0.02) << loss << " " << i;
      EXPECT_GT(mean, 1 - 4 * sigma - influence) << loss << " " << i;
      // So little chance that twice the variance would be seen, of positions too, which have 18 coordinates a block.
      EXPECT_LT(4 * sigma, i == kLevel || i == kPose ? 0.15 : 0.3) << loss << " " << i;
    }
  }
}

// A ray of an image that looks away tells nothing, and is the first suspect. Control keeps the point where it is.
TEST(Reliability, ARayThatIsNotSeenIsSuspectAndCountsForNothing) {
  Block block = test_block(small(5));
  const Examined before = adjusted_of(block, tested());
  const ImageId away{1000};
  block.images[away] = block.images.begin()->second;
  block.images[away].position.reset();
  const Eigen::Vector3d above(20, 10, 60);
  set_pose(block, away, {Eigen::Quaterniond::Identity(), -above});  // looks up
  const std::size_t count = block.control_observations.size();
  block.control_observations.push_back({block.control.begin()->first, away, {900, 700}, 0.5});
  Observation seen = block.observations.front();
  seen.image = away;
  block.observations.insert(block.observations.begin(), seen);
  const Examined after = adjusted_of(block, tested(), {.fixed_images = {away}});
  EXPECT_EQ(after.observation_count, before.observation_count);
  EXPECT_EQ(after.redundancy, before.redundancy);
  EXPECT_NEAR(after.sigma0, before.sigma0, 1e-6);
  const Reliability &was = *before.reliability, &is = *after.reliability;
  EXPECT_EQ(is.unseen, 2);
  EXPECT_EQ(is.tested, was.tested);
  EXPECT_EQ(is.groups[0].observations, was.groups[0].observations);
  EXPECT_NEAR(is.redundancy_sum, double(after.redundancy), 1e-4);
  ASSERT_EQ(is.suspects.size(), was.suspects.size() + 2);
  for (const TestedObservation& suspect : {is.suspects[0], is.suspects[1]}) {
    EXPECT_TRUE(std::isinf(suspect.w));
    EXPECT_EQ(suspect.source, suspect.group == ObservationGroup::kTieImages ? 0 : count);
  }
  EXPECT_NE(is.suspects[0].group, is.suspects[1].group);
  EXPECT_TRUE(std::isnan(is.tie_redundancy.front().x()));
}

TEST(Reliability, TheWorstSuspectIsThePlantedGrossError) {
  Block block = test_block(small(7));
  block.observations[50].pixel.y() += 12;
  const Examined adjusted = adjusted_of(block, tested());
  ASSERT_FALSE(adjusted.reliability->suspects.empty());
  const TestedObservation& worst = adjusted.reliability->suspects.front();
  EXPECT_EQ(worst.group, ObservationGroup::kTieImages);
  EXPECT_EQ(worst.source, 50u);
  EXPECT_NEAR(std::abs(worst.gross_error), 12, 4 * 0.5 / std::sqrt(worst.redundancy));
}

// Against an adjustment where the coordinates of the point really take no part.
TEST(Reliability, LeavingAControlPointOutIsWhatReadjustingWithoutItSays) {
  const Block block = test_block(small(3));
  const Examined with = adjusted_of(block, tested());
  ASSERT_GE(with.reliability->left_out.size(), 4u);
  for (const LeftOutPoint& left_out : with.reliability->left_out) {
    Block other = block;
    other.control.at(left_out.point).sigma_m.setConstant(std::numeric_limits<double>::infinity());
    const Examined without = adjusted_of(other, tested());
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
