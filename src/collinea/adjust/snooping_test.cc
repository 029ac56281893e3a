// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/snooping.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "collinea/adjust/test_block.h"

namespace collinea {
namespace {

using testing::test_block;

constexpr int kMost = 1000;

AdjustOptions plain() { return {.calibration = "focal_radial", .loss = "none", .position_loss = "none"}; }

testing::TestBlockOptions small(std::uint64_t seed = 1) {
  return {
      .rows = 3, .columns = 4, .points = 120, .sigma_px = 0.5, .position_sigma_m = 0.05, .control = 9, .seed = seed};
}

// Eight blunders of 15 sigmas in different points: all are found, worst first by round, and each is told within four of
// its standard deviations. Of 2000 good coordinates one exceeds the limit of 0.1 % by chance; a dozen never do.
TEST(Snooping, TakesOutPlantedBlundersAndTellsTheirSize) {
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
    const auto gone = std::find_if(snooped->taken_out.begin(), snooped->taken_out.end(), [&](const TakenOut& one) {
      return one.image == seen.image && one.point == seen.point && one.group == ObservationGroup::kTieImages;
    });
    ASSERT_NE(gone, snooped->taken_out.end()) << i;
    EXPECT_EQ(gone->axis, 1);
    EXPECT_NEAR(gone->blunder.y(), 7.5, 4 * gone->sigma);
    EXPECT_GT(gone->sigma, 0.5 * snooped->adjusted.sigma0);
    EXPECT_LT(gone->sigma, 2);
  }
  EXPECT_LT(snooped->taken_out.size(), planted.size() + 12);
  EXPECT_EQ(snooped->block.observations.size() + snooped->taken_out.size(), block.observations.size());
  EXPECT_NEAR(snooped->adjusted.sigma0, 1, 0.1);
  EXPECT_GT(snooped->sigma0_before, 1.1);
  EXPECT_EQ(snooped->adjusted.reliability->rejected, 0);
}

TEST(Snooping, BlundersOnTheGroundGoByPlanAndHeight) {
  Block block = test_block(small(3));
  const ControlId wrong{3};
  block.control.at(wrong).position_in_world.z() += 0.3;
  const ImageId image{14};
  block.images.at(image).position->position_in_world.x() -= 1;
  const auto snooped = snoop(block, {}, plain(), kMost, {});
  ASSERT_TRUE(snooped) << snooped.error().message;
  ASSERT_GE(snooped->taken_out.size(), 2u);
  bool height = false, plan = false;
  for (const TakenOut& gone : snooped->taken_out) {
    if (gone.group == ObservationGroup::kControlHeight && gone.control == wrong) {
      height = true;
      EXPECT_NEAR(gone.blunder.z(), 0.3, 4 * gone.sigma);
    }
    if (gone.group == ObservationGroup::kPositionPlan && gone.image == image) {
      plan = true;
      EXPECT_NEAR(gone.blunder.x(), -1, 4 * gone.sigma);
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
  ASSERT_FALSE(snooped->taken_out.empty());
  const TakenOut& first = snooped->taken_out.front();
  EXPECT_EQ(first.group, ObservationGroup::kControlImages);
  EXPECT_EQ(first.image, block.control_observations[5].image);
  EXPECT_EQ(first.control, block.control_observations[5].point);
  EXPECT_NEAR(first.blunder.x(), 900, 5);
  EXPECT_NEAR(first.blunder.y(), -500, 5);
  EXPECT_LT(snooped->taken_out.size(), 8u);
}

// Two control points carry the scale alone: a wrong distance shows in neither more than in the other.
TEST(Snooping, WhatNothingElseChecksStays) {
  Block block = test_block({.rows = 2, .columns = 3, .points = 120, .sigma_px = 0.5, .control = 4});
  block.control.erase(ControlId{2});  // the check point
  std::erase_if(block.control_observations, [](const auto& seen) { return seen.point == ControlId{2}; });
  block.control.at(ControlId{3}).position_in_world.z() += 1;
  const auto snooped = snoop(block, {}, plain(), kMost, {});
  ASSERT_TRUE(snooped) << snooped.error().message;
  EXPECT_EQ(snooped->adjusted.rank_defect, 0);
  for (const auto& [id, control] : snooped->block.control) EXPECT_TRUE(control.sigma_m.allFinite()) << control.name;
}

TEST(Snooping, TheBoundHoldsAndIsTold) {
  Block block = test_block(small());
  for (std::size_t i = 0; i < block.observations.size(); i += 40) block.observations[i].pixel.x() += 10;
  const auto snooped = snoop(block, {}, plain(), 5, {});
  ASSERT_TRUE(snooped) << snooped.error().message;
  EXPECT_FALSE(snooped->finished);
  EXPECT_EQ(snooped->taken_out.size(), 5u);
}

TEST(Snooping, ThreadsDoNotChangeWhatGoes) {
  Block block = test_block({.rows = 4, .columns = 5, .points = 900, .sigma_px = 0.5, .position_sigma_m = 0.05});
  for (std::size_t i = 0; i < block.observations.size(); i += 300) block.observations[i].pixel.x() += 6;
  collinea::Run one, three;
  three.threads = 3;
  const auto a = snoop(block, {}, plain(), kMost, one), b = snoop(block, {}, plain(), kMost, three);
  ASSERT_TRUE(a && b);
  ASSERT_EQ(a->taken_out.size(), b->taken_out.size());
  for (std::size_t i = 0; i < a->taken_out.size(); ++i) {
    EXPECT_EQ(a->taken_out[i].point, b->taken_out[i].point);
    EXPECT_EQ(a->taken_out[i].w, b->taken_out[i].w);
    EXPECT_EQ(a->taken_out[i].sigma, b->taken_out[i].sigma);
  }
}

}  // namespace
}  // namespace collinea
