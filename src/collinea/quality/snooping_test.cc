// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/snooping.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <string>

#include "collinea/adjust/survey_block.h"
#include "collinea/math/quantiles.h"
#include "collinea/quality/internal/test_examine.h"

namespace collinea {
namespace {

using testing::Surveyed;
using testing::test_block;

constexpr int kMost = 1000;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

ExamineOptions plain() {
  return {.adjust = {.calibration = Calibration::kFocalRadial, .loss = Loss::kNone, .position_loss = Loss::kNone}};
}

testing::TestBlockOptions small(std::uint64_t seed = 1) {
  return {
      .rows = 3, .columns = 4, .points = 120, .sigma_px = 0.5, .position_sigma_m = 0.05, .control = 9, .seed = seed};
}

// Eight gross errors of 15 sigmas in different points: all are found, worst first by round, and each is reported within
// four of its standard deviations. Of 2000 good coordinates one exceeds the limit of 0.1 % by chance; a dozen never do.
TEST(Snooping, TakesOutPlantedGrossErrorsAndTellsTheirSize) {
  Block block = test_block(small());
  std::vector<std::size_t> planted;
  for (std::size_t i = 20; planted.size() < 8; i += block.observations.size() / 9) {
    planted.push_back(i);
    block.observations[i].pixel.y() += 7.5;
  }
  const auto snooped = snoop(block, {}, plain(), kMost, {});
  ASSERT_TRUE(snooped) << snooped.error().message;
  EXPECT_TRUE(snooped->finished);
  EXPECT_GT(snooped->rounds, 1);
  for (const std::size_t i : planted) {
    const Observation& seen = block.observations[i];
    const auto rejected = std::find_if(snooped->rejected.begin(), snooped->rejected.end(), [&](const Rejected& one) {
      return one.image == seen.image && one.point == seen.point && one.group == ObservationGroup::kTieImages;
    });
    ASSERT_NE(rejected, snooped->rejected.end()) << i;
    EXPECT_EQ(rejected->axis, 1);
    EXPECT_NEAR(rejected->gross_error.y(), 7.5, 4 * rejected->sigma);
    EXPECT_GT(rejected->sigma, 0.5 * snooped->adjusted.sigma0);
    EXPECT_LT(rejected->sigma, 2);
  }
  EXPECT_LT(snooped->rejected.size(), planted.size() + 12);
  EXPECT_EQ(snooped->block.observations.size() + snooped->rejected.size(), block.observations.size());
  EXPECT_NEAR(snooped->adjusted.sigma0, 1, 0.1);
  EXPECT_GT(snooped->sigma0_before, 1.1);
  EXPECT_EQ(snooped->adjusted.reliability->rejected, 0);
}

TEST(Snooping, GeodeticGrossErrorsGoByPlanAndHeight) {
  Block block = test_block(small(3));
  const ControlId wrong{3};
  block.control.at(wrong).position_in_world.z() += 0.3;
  const ImageId image{14};
  block.images.at(image).position->position_in_world.x() -= 1;
  const auto snooped = snoop(block, {}, plain(), kMost, {});
  ASSERT_TRUE(snooped) << snooped.error().message;
  ASSERT_GE(snooped->rejected.size(), 2u);
  bool height = false, plan = false;
  for (const Rejected& rejected : snooped->rejected) {
    if (rejected.group == ObservationGroup::kControlHeight && rejected.control == wrong) {
      height = true;
      EXPECT_NEAR(rejected.gross_error.z(), 0.3, 4 * rejected.sigma);
    }
    if (rejected.group == ObservationGroup::kPositionPlan && rejected.image == image) {
      plan = true;
      EXPECT_NEAR(rejected.gross_error.x(), -1, 4 * rejected.sigma);
    }
  }
  EXPECT_TRUE(height && plan);
  EXPECT_TRUE(std::isinf(snooped->block.control.at(wrong).sigma_m.z()));
  EXPECT_TRUE(std::isfinite(snooped->block.control.at(wrong).sigma_m.x()));
}

// A mark measured a thousand pixels off would bend the block; it goes first, and everything else stays.
TEST(Snooping, AGrossMeasurementOfControlGoesFirst) {
  Block block = test_block(small(4));
  block.control_observations[5].pixel += Eigen::Vector2d(900, -500);
  const auto snooped = snoop(block, {}, plain(), kMost, {});
  ASSERT_TRUE(snooped) << snooped.error().message;
  ASSERT_FALSE(snooped->rejected.empty());
  const Rejected& first = snooped->rejected.front();
  EXPECT_EQ(first.group, ObservationGroup::kControlImages);
  EXPECT_EQ(first.image, block.control_observations[5].image);
  EXPECT_EQ(first.control, block.control_observations[5].point);
  EXPECT_NEAR(first.gross_error.x(), 900, 5);
  EXPECT_NEAR(first.gross_error.y(), -500, 5);
  EXPECT_LT(snooped->rejected.size(), 8u);
}

std::optional<StayReason> reason_of(const Snooped& snooped, ObservationGroup group, std::uint32_t source) {
  for (const KeptSuspect& one : snooped.kept)
    if (one.observation.group == group && one.observation.source == source) return one.reason;
  return std::nullopt;
}

// Two distances say different things of the scale, which nothing else tells; the rays of their points are far better.
TEST(Snooping, WhichOfTwoThatContradictEachOtherIsWrongCannotBeTold) {
  Block block = test_block({.rows = 2, .columns = 3, .points = 80, .sigma_px = 0.5, .control = 6});
  for (auto& [id, control] : block.control) control.sigma_m.setConstant(kInfinity);
  const auto between = [&](std::uint32_t a, std::uint32_t b) {
    return (block.control.at({a}).position_in_world - block.control.at({b}).position_in_world).norm();
  };
  block.geodetic = {{.from = {0}, .to = {1}, .value = between(0, 1), .sigma = 0.2},
                    {.from = {3}, .to = {4}, .value = 1.2 * between(3, 4), .sigma = 0.2}};
  ExamineOptions options = plain();
  options.test.sigma0_known = true;
  const auto snooped = snoop(block, {}, options, kMost, {});
  ASSERT_TRUE(snooped) << snooped.error().message;
  EXPECT_EQ(snooped->adjusted.rank_defect, 6);
  for (const std::uint32_t i : {0u, 1u}) {
    EXPECT_EQ(snooped->block.geodetic[i].role, ControlRole::kControl);
    EXPECT_EQ(reason_of(*snooped, ObservationGroup::kDistance, i), StayReason::kSameDegree);
  }
}

// Three points: nothing checks their heights, and a wrong one shows nowhere.
TEST(Snooping, WhatNothingElseChecksStays) {
  Block block = test_block({.rows = 2, .columns = 3, .points = 120, .sigma_px = 0.5, .control = 4});
  block.control.erase(ControlId{2});  // the check point
  std::erase_if(block.control_observations, [](const auto& seen) { return seen.point == ControlId{2}; });
  block.control.at(ControlId{3}).position_in_world.z() += 1;
  const auto snooped = snoop(block, {}, plain(), kMost, {});
  ASSERT_TRUE(snooped) << snooped.error().message;
  EXPECT_EQ(snooped->adjusted.rank_defect, 0);
  for (const auto& [id, control] : snooped->block.control) EXPECT_TRUE(control.sigma_m.allFinite()) << control.name;
  for (const TestedObservation& one : snooped->adjusted.reliability->others)
    if (one.group == ObservationGroup::kControlHeight) {
      EXPECT_LT(one.redundancy, 0.1);
      if (std::abs(one.w) > snooped->adjusted.reliability->limit) {
        EXPECT_EQ(reason_of(*snooped, one.group, one.source), StayReason::kTooLittleChecks);
      }
    }
}

// A point measured twice in one image, once far off: only that measurement goes.
TEST(Snooping, OfTwoMarksInOneImageTheWrongOneGoes) {
  Block block = test_block(small(4));
  ControlObservation wrong = block.control_observations[5];
  wrong.pixel += Eigen::Vector2d(900, -500);
  block.control_observations.push_back(wrong);
  const auto snooped = snoop(block, {}, plain(), kMost, {});
  ASSERT_TRUE(snooped) << snooped.error().message;
  int of_point = 0;
  for (const ControlObservation& seen : snooped->block.control_observations)
    if (seen.point == wrong.point && seen.image == wrong.image) {
      ++of_point;
      EXPECT_EQ(seen.pixel, block.control_observations[5].pixel);
    }
  EXPECT_EQ(of_point, 1);
}

TEST(Snooping, TheBoundHoldsForGrossMeasurementsToo) {
  Block block = test_block(small(4));
  for (const std::size_t i : {5, 20, 33}) block.control_observations[i].pixel += Eigen::Vector2d(700, 600);
  const auto snooped = snoop(block, {}, plain(), 2, {});
  ASSERT_TRUE(snooped) << snooped.error().message;
  EXPECT_EQ(snooped->rejected.size(), 2u);
  EXPECT_FALSE(snooped->finished);
}

TEST(Snooping, TheBoundHoldsAndIsStated) {
  Block block = test_block(small());
  for (std::size_t i = 0; i < block.observations.size(); i += 40) block.observations[i].pixel.x() += 10;
  const auto snooped = snoop(block, {}, plain(), 5, {});
  ASSERT_TRUE(snooped) << snooped.error().message;
  EXPECT_FALSE(snooped->finished);
  EXPECT_EQ(snooped->rejected.size(), 5u);
}

TEST(Snooping, ThreadsDoNotChangeWhatGoes) {
  Block block = test_block({.rows = 4, .columns = 5, .points = 900, .sigma_px = 0.5, .position_sigma_m = 0.05});
  for (std::size_t i = 0; i < block.observations.size(); i += 300) block.observations[i].pixel.x() += 6;
  collinea::Run one, three;
  three.threads = 3;
  const auto a = snoop(block, {}, plain(), kMost, one), b = snoop(block, {}, plain(), kMost, three);
  ASSERT_TRUE(a && b);
  ASSERT_EQ(a->rejected.size(), b->rejected.size());
  for (std::size_t i = 0; i < a->rejected.size(); ++i) {
    EXPECT_EQ(a->rejected[i].point, b->rejected[i].point);
    EXPECT_EQ(a->rejected[i].w, b->rejected[i].w);
    EXPECT_EQ(a->rejected[i].sigma, b->rejected[i].sigma);
  }
}

// --- measurements on the ground, and attitudes

// Exact positions, then errors of everything.
Surveyed surveyed(std::uint64_t seed) {
  testing::TestBlockOptions options{.rows = 2, .columns = 4, .points = 60, .control = 6, .seed = seed};
  Surveyed made{test_block(options), {}};
  Random of_geodetic(seed, 11), random(seed, 12);
  std::vector<ControlId> ids;
  for (const auto& [id, control] : made.block.control) ids.push_back(id);
  testing::measure_geodetic(made.block, made.block, ids, 0.003, 2e-4, of_geodetic);
  const auto measure = [&](auto& seen) {
    const double du = random.normal(), dv = random.normal();
    seen.pixel += 0.5 * Eigen::Vector2d(du, dv);
    seen.sigma_px = 0.5;
  };
  for (Observation& seen : made.block.observations) measure(seen);
  for (ControlObservation& seen : made.block.control_observations) measure(seen);
  for (auto& [id, control] : made.block.control) {
    control.role = ControlRole::kControl;
    control.sigma_m.setConstant(0.01);
    control.position_in_world += 0.01 * testing::normal3(random);
  }
  for (const auto& [id, pose] : oriented_images(made.block)) {
    const Eigen::Vector3d sigma(4e-4, 4e-4, 6e-4);
    made.scope.attitudes[id] = {
        (pose.rotation * rotation_by(sigma.cwiseProduct(testing::normal3(random)))).normalized(), sigma};
  }
  made.scope.use_positions = false;
  return made;
}

// One gross error of 5 to 12 sigmas in a measurement on the ground and one in an attitude of each of 100 blocks: as
// many are found as theory says, within four binomial deviations, and of good ones no more go than the level allows.
TEST(Snooping, GrossErrorsOnTheGroundAndInAttitudesAreFoundWithTheTheoreticalPower) {
  ExamineOptions options = plain();
  options.adjust.calibration = Calibration::kNone;
  options.reliability = true;
  std::map<bool, double> planted, found, expected, variance;  // false: on the ground, true: attitudes
  double good = 0, alarms = 0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    Surveyed made = surveyed(seed);
    const auto clean = examine(made.block, made.scope, options, {});
    ASSERT_TRUE(clean && clean->reliability);
    Random random(seed, 13);
    std::set<std::pair<ObservationGroup, std::uint32_t>> wrong;
    for (const bool attitude : {false, true}) {
      std::vector<TestedObservation> all;
      for (const TestedObservation& one : clean->reliability->others)
        if (one.redundancy > 0.1 &&
            (attitude ? one.group >= ObservationGroup::kAttitudeLevel
                      : one.group >= ObservationGroup::kDistance && one.group <= ObservationGroup::kOnLine))
          all.push_back(one);
      ASSERT_GT(all.size(), 10u);
      const TestedObservation& one = all[random.below(static_cast<std::uint32_t>(all.size()))];
      const double sigmas = (random.uniform() < 0.5 ? -1 : 1) * random.uniform(5, 12);
      if (attitude) {
        Eigen::Quaterniond& given = made.scope.attitudes.at(ImageId{one.source}).cam_from_world;
        given = (given * rotation_by(sigmas * one.sigma * Eigen::Vector3d::Unit(one.axis))).normalized();
      } else {
        made.block.geodetic[one.source].value += sigmas * one.sigma;
      }
      wrong.insert({one.group, one.source});
      const double power = power_of_test(sigmas * std::sqrt(one.redundancy), clean->reliability->limit);
      ++planted[attitude];
      expected[attitude] += power;
      variance[attitude] += power * (1 - power);
    }
    const auto snooped = snoop(made.block, made.scope, options, kMost, {});
    ASSERT_TRUE(snooped) << snooped.error().message;
    for (const Rejected& rejected : snooped->rejected) {
      if (rejected.group < ObservationGroup::kDistance) continue;
      const bool attitude = rejected.group >= ObservationGroup::kAttitudeLevel;
      const std::uint32_t source = attitude ? rejected.image.value : rejected.geodetic;
      if (wrong.contains({rejected.group, source}))
        ++found[attitude];
      else
        ++alarms;
      // What went stands in the result as a comparison.
      if (attitude) {
        const Eigen::Vector3d& sigma = snooped->attitudes.at(rejected.image).sigma_rad;
        EXPECT_TRUE(std::isinf(rejected.group == ObservationGroup::kAttitudeHeading ? sigma.z() : sigma.x()));
      } else {
        EXPECT_EQ(snooped->block.geodetic[rejected.geodetic].role, ControlRole::kCheck);
      }
    }
    good += static_cast<double>(3 * made.scope.attitudes.size() + made.block.geodetic.size());
  }
  for (const bool attitude : {false, true}) {
    EXPECT_NEAR(found[attitude], expected[attitude], 4 * std::sqrt(variance[attitude]) + 0.5) << attitude;
    EXPECT_GT(expected[attitude], 60);
    EXPECT_LT(expected[attitude], 99.5);
  }
  EXPECT_NEAR(alarms, 0.001 * good, 4 * std::sqrt(0.001 * good));
}

}  // namespace
}  // namespace collinea
