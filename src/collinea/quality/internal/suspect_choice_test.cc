// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/internal/suspect_choice.h"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

namespace collinea {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr ChoiceBounds kUnbounded{1000, 1000};

// Points of three rays, in as many images as asked for; what is measured on the ground between control points.
Block block_of(std::uint32_t points, std::uint32_t images) {
  Block block;
  for (std::uint32_t p = 0; p < points; ++p)
    for (std::uint32_t i = 0; i < images; ++i) block.observations.push_back({.image = {i}, .point = {p}, .pixel = {}});
  for (std::uint32_t c = 0; c < 4; ++c) {
    block.control[{c}];
    block.control_observations.push_back({.point = {c}, .image = {0}, .pixel = {}});
  }
  for (std::uint32_t c = 1; c < 4; ++c)
    block.geodetic.push_back({.kind = GeodeticKind::kDistance, .from = {c - 1}, .to = {c}});
  return block;
}

// Everything in it takes part, and these are suspect.
Examined examined(const Block& block, const std::vector<TestedObservation>& suspects) {
  Examined adjusted;
  for (std::uint32_t i = 0; i < block.observations.size(); ++i) adjusted.observations.push_back(i);
  adjusted.reliability.emplace();
  adjusted.reliability->limit = 3;
  adjusted.reliability->suspects = suspects;
  return adjusted;
}

TestedObservation suspect(ObservationGroup group, std::uint32_t source, double w, double redundancy = 0.8) {
  return {.group = group, .source = source, .redundancy = redundancy, .w = w, .limit = 3, .suspicion = w};
}

TestedObservation ray(std::uint32_t source, double w, double redundancy = 0.8) {
  return suspect(ObservationGroup::kTieImages, source, w, redundancy);
}

std::vector<std::uint32_t> sources(const SuspectChoice& choice) {
  std::vector<std::uint32_t> all;
  for (const ChosenSuspect& one : choice.suspects) all.push_back(one.test.source);
  return all;
}

using Sources = std::vector<std::uint32_t>;

TEST(SuspectChoice, OfEachPointOneRayGoes) {
  const Block block = block_of(20, 3);
  TestedObservation other_axis = ray(0, 8);
  other_axis.axis = 1;
  const auto choice =
      choose_suspects(examined(block, {ray(0, 9), other_axis, ray(1, 7), ray(5, 6)}), block, {}, kUnbounded);
  EXPECT_EQ(sources(choice), (Sources{0, 5}));
  EXPECT_TRUE(choice.kept.empty() && choice.last_rays.empty());
  EXPECT_FALSE(choice.bound_is_reached);
}

// 20 rays in an image: a worse one may explain half of its w in another.
TEST(SuspectChoice, ARayThatAWorseOneOfItsImageMayHaveSpoiltWaits) {
  const Block block = block_of(20, 3);
  EXPECT_EQ(sources(choose_suspects(examined(block, {ray(0, 10), ray(3, 7.9)}), block, {}, kUnbounded)), (Sources{0}));
  EXPECT_EQ(sources(choose_suspects(examined(block, {ray(0, 10), ray(3, 8.5)}), block, {}, kUnbounded)),
            (Sources{0, 3}));
}

TEST(SuspectChoice, AnImageKeepsSixRays) {
  const Block block = block_of(7, 3);
  std::vector<TestedObservation> all;
  for (const std::uint32_t p : {0u, 1u}) all.push_back(ray(3 * p, kInfinity));
  EXPECT_EQ(choose_suspects(examined(block, all), block, {}, kUnbounded).suspects.size(), 2u);  // not seen: always
  all = {ray(0, 1000), ray(3, 999)};
  const auto choice = choose_suspects(examined(block, all), block, {}, kUnbounded);
  EXPECT_EQ(sources(choice), (Sources{0}));
  ASSERT_EQ(choice.kept.size(), 1u);
  EXPECT_EQ(choice.kept[0].reason, StayReason::kImageNeedsIt);
}

TEST(SuspectChoice, OfTwoRaysBothGo) {
  const Block block = block_of(20, 2);
  const auto choice = choose_suspects(examined(block, {ray(7, 9)}), block, {}, kUnbounded);
  ASSERT_EQ(choice.suspects.size(), 1u);
  EXPECT_TRUE(choice.suspects[0].as_pair);
  ASSERT_EQ(choice.last_rays.size(), 1u);
  EXPECT_EQ(choice.last_rays[0].source, 6u);
  EXPECT_EQ(choice.last_rays[0].group, ObservationGroup::kTieImages);
}

TEST(SuspectChoice, OfAllThatAreNoImagePointsOnlyTheWorstGoesAndNothingLessSuspectWithIt) {
  const Block block = block_of(20, 3);
  const auto choice = choose_suspects(examined(block, {ray(0, 12), suspect(ObservationGroup::kDistance, 1, 11),
                                                       suspect(ObservationGroup::kControlPlan, 3, 10), ray(7, 9)}),
                                      block, {}, kUnbounded);
  EXPECT_EQ(sources(choice), (Sources{0, 1}));
  ASSERT_TRUE(choice.rivals);
  EXPECT_EQ(choice.rivals->worst.group, ObservationGroup::kDistance);
}

TEST(SuspectChoice, CoordinatesWaitForAWorseRayOfTheirPoint) {
  const Block block = block_of(20, 3);
  const TestedObservation of_control = suspect(ObservationGroup::kControlImages, 1, 12);
  const auto goes = [&](const TestedObservation& other) {
    return choose_suspects(examined(block, {of_control, other}), block, {}, kUnbounded).suspects.size() == 2;
  };
  EXPECT_FALSE(goes(suspect(ObservationGroup::kControlPlan, 1, 11)));
  EXPECT_FALSE(goes(suspect(ObservationGroup::kDistance, 1, 11)));  // from 1 to 2
  EXPECT_TRUE(goes(suspect(ObservationGroup::kDistance, 2, 11)));   // from 2 to 3
}

TEST(SuspectChoice, WhatLittleChecksStaysAndWithItTheRaysOfItsPoint) {
  const Block block = block_of(20, 3);
  const auto choice =
      choose_suspects(examined(block, {suspect(ObservationGroup::kControlPlan, 1, 20, 0.005),
                                       suspect(ObservationGroup::kControlImages, 1, 12),
                                       suspect(ObservationGroup::kDistance, 2, 11, 0.05), ray(7, 9), ray(10, 8, 0.05)}),
                      block, {}, kUnbounded);
  EXPECT_EQ(sources(choice), (Sources{7}));
  ASSERT_EQ(choice.kept.size(), 4u);
  EXPECT_EQ(choice.kept[0].reason, StayReason::kTooLittleChecks);
  EXPECT_EQ(choice.kept[1].reason, StayReason::kWorseOfItsPoint);
  EXPECT_EQ(choice.kept[2].reason, StayReason::kTooLittleChecks);  // 0.05: only after another that stays
  EXPECT_EQ(choice.kept[3].reason, StayReason::kTooLittleChecks);
  EXPECT_EQ(sources(choose_suspects(examined(block, {suspect(ObservationGroup::kDistance, 2, 11, 0.05)}), block, {},
                                    kUnbounded)),
            (Sources{2}));
}

TEST(SuspectChoice, WhatAnEarlierRoundFoundNeededStays) {
  const Block block = block_of(20, 3);
  const StayReasons stays{{measurement_at({ObservationGroup::kTieImages, 0}, block), StayReason::kBlockNeedsIt}};
  const auto choice = choose_suspects(examined(block, {ray(0, 9), ray(3, 8)}), block, stays, kUnbounded);
  EXPECT_EQ(sources(choice), (Sources{3}));
  ASSERT_EQ(choice.kept.size(), 1u);
  EXPECT_EQ(choice.kept[0].reason, StayReason::kBlockNeedsIt);
}

TEST(SuspectChoice, BoundsHold) {
  const Block block = block_of(20, 3);
  const std::vector<TestedObservation> all = {ray(0, 90), ray(4, 90), ray(8, 90)};
  const auto of_round = choose_suspects(examined(block, all), block, {}, {2, 1000});
  EXPECT_EQ(of_round.suspects.size(), 2u);
  EXPECT_FALSE(of_round.bound_is_reached);
  const auto in_all = choose_suspects(examined(block, all), block, {}, {1000, 2});
  EXPECT_EQ(in_all.suspects.size(), 2u);
  EXPECT_TRUE(in_all.bound_is_reached);
}

}  // namespace
}  // namespace collinea
