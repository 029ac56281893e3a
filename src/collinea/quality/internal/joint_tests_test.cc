// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/internal/joint_tests.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "collinea/adjust/survey_block.h"
#include "collinea/quality/internal/test_examine.h"

namespace collinea {
namespace {

using testing::test_block;
using testing::tested;

// Control on the ground and in images, positions, and distances.
Block block_of(std::uint64_t seed = 1) {
  Block block = test_block(
      {.rows = 1, .columns = 5, .points = 60, .sigma_px = 0.5, .position_sigma_m = 0.05, .control = 6, .seed = seed});
  for (auto& [id, point] : block.control) point.role = ControlRole::kControl;
  for (std::uint32_t i = 1; i < 4; ++i) {
    const double value = (block.control.at({i}).position_in_world - block.control.at({i - 1}).position_in_world).norm();
    block.geodetic.push_back({.from = {i - 1}, .to = {i}, .value = value, .sigma = 0.02});
  }
  block.control.at({4}).correlation = {0.5, 0, 0.3};
  return block;
}

JointSystem system_of(const Block& block, bool sigma0_known = true) {
  ExamineOptions options = tested();
  options.adjust.settle_points = true;
  Result<Solved> solved = solve_bundle(block, {}, options.adjust, {});
  const auto [factor, failed_row] = solved->factor({});
  return joint_system(*solved, *factor, 1000, sigma0_known, {});
}

const TestedObservation* find(const Reliability& tests, const JointSystem& system, std::size_t row) {
  const MeasurementIndex index = system.measurements[system.rows[row].measurement];
  for (const TestedObservation& one : tests.others)
    if (one.group == index.group && one.source == index.source && one.axis == system.rows[row].axis) return &one;
  return nullptr;
}

// Every coordinate that was given has the redundancy number and the test that it has by the selected inverse.
TEST(JointTests, OfSingleCoordinatesAreThoseOfReliability) {
  const Block block = block_of();
  for (const bool known : {true, false}) {
    ExamineOptions options = tested();
    options.test.sigma0_known = known;
    const auto examined = examine(block, {}, options, {});
    ASSERT_TRUE(examined && examined->reliability);
    const JointSystem system = system_of(block, known);
    EXPECT_EQ(system.rows.size(), examined->reliability->others.size());
    const JointOutcome outcome = without_set(system, {});
    for (std::size_t row = 0; row < system.rows.size(); ++row) {
      const TestedObservation* one = find(*examined->reliability, system, row);
      ASSERT_TRUE(one);
      EXPECT_NEAR(outcome.tests[row].redundancy, one->redundancy, 1e-6);
      EXPECT_NEAR(outcome.tests[row].w, one->w, 1e-3 * (1 + std::abs(one->w)));
    }
  }
}

// What the joint cofactors say of the tests without two measurements an adjustment without them says too.
TEST(JointTests, WithoutASetTheyAreThoseOfAnAdjustmentWithoutIt) {
  Block block = block_of(2);
  block.control.at({2}).position_in_world.z() += 0.03;
  const JointSystem system = system_of(block);
  const auto number = [&](ObservationGroup group, std::uint32_t source) {
    const auto its = std::ranges::find_if(
        system.measurements, [&](const MeasurementIndex& one) { return one.group == group && one.source == source; });
    return std::size_t(its - system.measurements.begin());
  };
  const std::size_t set[] = {number(ObservationGroup::kControlPlan, 4), number(ObservationGroup::kControlHeight, 2)};
  const JointOutcome outcome = without_set(system, set);
  ASSERT_TRUE(outcome.is_determined);
  const MeasurementIndex indices[] = {system.measurements[set[0]], system.measurements[set[1]]};
  ExamineOptions options = tested();
  options.test.sigma0_known = true;
  const auto left = examine(without({block, {}}, indices).block, {}, options, {});
  const auto all = examine(block, {}, options, {});
  ASSERT_TRUE(left && left->reliability && all);
  EXPECT_NEAR(outcome.statistic,
              std::pow(all->sigma0, 2) * double(all->redundancy) - std::pow(left->sigma0, 2) * double(left->redundancy),
              1e-2 * outcome.statistic);
  EXPECT_NEAR(joint_statistic(system, set), outcome.statistic, 1e-9 * outcome.statistic);
  int compared = 0;
  for (std::size_t row = 0; row < system.rows.size(); ++row)
    if (const TestedObservation* one = find(*left->reliability, system, row)) {
      ++compared;
      EXPECT_NEAR(outcome.tests[row].redundancy, one->redundancy, 5e-3);
      EXPECT_NEAR(outcome.tests[row].w, one->w, 0.03 * (1 + std::abs(one->w)));
    }
  EXPECT_EQ(compared, int(system.rows.size()) - 3);
  EXPECT_NEAR(outcome.tests[std::size_t(system.first[set[1]])].gross_error, 0.03, 0.05);
}

// Of the errors of 200 blocks: T of the plan and the height of two points is chi-squared with three degrees of freedom.
TEST(JointTests, TheStatisticIsChiSquared) {
  double sum = 0;
  constexpr int kBlocks = 200;
  for (std::uint64_t seed = 1; seed <= kBlocks; ++seed) {
    const Block block =
        test_block({.rows = 1, .columns = 3, .points = 25, .sigma_px = 0.5, .control = 6, .seed = seed});
    const JointSystem system = system_of(block);
    std::vector<std::size_t> set;
    for (std::size_t i = 0; i < system.measurements.size(); ++i)
      if ((system.measurements[i].group == ObservationGroup::kControlPlan && set.empty()) ||
          (system.measurements[i].group == ObservationGroup::kControlHeight && set.size() == 1))
        set.push_back(i);
    ASSERT_EQ(set.size(), 2u);
    sum += joint_statistic(system, set);
  }
  EXPECT_NEAR(sum / kBlocks, 3, 4 * std::sqrt(6.0 / kBlocks));
}

// Two distances between the same points, both twice: which pair is wrong nothing says.
TEST(JointTests, SetsThatSayTheSameAreCorrelated) {
  Block block = block_of();
  for (auto& [id, point] : block.control) point.sigma_m.setConstant(std::numeric_limits<double>::infinity());
  block.control.at({4}).correlation.setZero();
  for (auto& [id, image] : block.images) image.position.reset();
  const GeodeticObservation first = block.geodetic[0], second = block.geodetic[1];
  block.geodetic = {first, second, first, second};
  const JointSystem system = system_of(block);
  std::vector<std::size_t> distances;
  for (std::size_t i = 0; i < system.measurements.size(); ++i)
    if (system.measurements[i].group == ObservationGroup::kDistance) distances.push_back(i);
  ASSERT_EQ(distances.size(), 4u);
  const std::size_t a[] = {distances[0], distances[1]}, b[] = {distances[2], distances[3]}, c[] = {distances[0]};
  EXPECT_GT(joint_correlation(system, a, b), 0.2);
  EXPECT_LE(joint_correlation(system, a, b), 1 + 1e-9);
  EXPECT_EQ(joint_correlation(system, a, a), 0);
  EXPECT_EQ(joint_correlation(system, {}, c), 0);
}

// Errors that are added to a system are those of an adjustment of them.
TEST(JointTests, ErrorsCanBeAddedAfterwards) {
  const Block good = block_of(3);
  Block wrong = good;
  wrong.control.at({1}).position_in_world += Eigen::Vector3d(0.02, 0, 0.03);
  const JointSystem expected = system_of(wrong), system = system_of(good);
  std::vector<std::size_t> rows;
  std::vector<double> errors;
  for (std::size_t row = 0; row < system.rows.size(); ++row) {
    const MeasurementIndex& index = system.measurements[system.rows[row].measurement];
    if (traits_of(index.group).source != ObservationSource::kControlCoordinates || index.source != 1) continue;
    rows.push_back(row);
    errors.push_back(Eigen::Vector3d(0.02, 0, 0.03)[system.rows[row].axis]);
  }
  ASSERT_EQ(rows.size(), 3u);
  const JointSystem added = with_errors(system, rows, errors);
  EXPECT_NEAR(added.squares, expected.squares, 0.02 * expected.squares);
  const JointOutcome here = without_set(added, {}), there = without_set(expected, {});
  for (std::size_t row = 0; row < here.tests.size(); ++row)
    EXPECT_NEAR(here.tests[row].w, there.tests[row].w, 0.05 * (1 + std::abs(there.tests[row].w)));
}

TEST(JointTests, NothingIsSaidOfABlockWithoutGivenMeasurements) {
  const Block block = test_block({.rows = 1, .columns = 3, .points = 25, .sigma_px = 0.5});
  const JointSystem system = system_of(block);
  EXPECT_TRUE(system.measurements.empty());
  EXPECT_TRUE(explanations(system, 3.3).empty());
  EXPECT_TRUE(explanations(JointSystem(), 3.3).empty());
}

}  // namespace
}  // namespace collinea
