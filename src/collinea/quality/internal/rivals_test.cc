// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/internal/rivals.h"

#include <gtest/gtest.h>

#include <vector>

namespace collinea {
namespace {

constexpr double kLimit = 3.3, kRedundancy = 0.5;

Block two_distances() {
  Block block;
  block.geodetic = {{.kind = GeodeticKind::kDistance}, {.kind = GeodeticKind::kDistance}};
  return block;
}

TestedObservation distance(std::uint32_t source, double suspicion, double redundancy = kRedundancy) {
  return {.group = ObservationGroup::kDistance,
          .source = source,
          .redundancy = redundancy,
          .w = suspicion,
          .suspicion = suspicion};
}

Reliability tests_of(const std::vector<TestedObservation>& all) {
  Reliability tests;
  tests.limit = kLimit;
  tests.others = tests.suspects = all;
  return tests;
}

// Two tests of this correlation: the redundancy of the second falls when the first goes.
StayReasons doubts_of(double suspicion, double other_suspicion, double correlation, double redundancy = kRedundancy,
                      double w_without = 0) {
  const Block block = two_distances();
  const Reliability tests = tests_of({distance(0, suspicion, redundancy), distance(1, other_suspicion)});
  const Rivals rivals = rivals_of(tests.suspects[0], tests, block);
  return doubts(rivals, tests_of({distance(1, w_without, kRedundancy * (1 - correlation * correlation))}), block);
}

TEST(Rivals, OfTwoThatSayTheSameOfThemselvesNeitherGoes) {
  const StayReasons both = doubts_of(8, -7.95, 0.999);
  EXPECT_EQ(both.size(), 2u);
  for (const auto& [measurement, reason] : both) EXPECT_EQ(reason, StayReason::kSameDegree);
}

TEST(Rivals, TwoOfTheSameSizeThatHaveNothingToDoWithEachOtherBothGo) { EXPECT_TRUE(doubts_of(8, 8, 0.5).empty()); }

TEST(Rivals, OneThatIsLessSuspectIsNoRival) { EXPECT_TRUE(doubts_of(8, 7, 0.999).empty()); }

// The difference of two tests has the variance 2 (1 - rho): with 0.875 one that is behind by half the limit is not
// to be told from the worst, one by 0.51 of it is; and only if without the worst it is no suspect any more.
TEST(Rivals, OneThatLittleChecksGoesOnlyWhenItIsWrongBeyondDoubt) {
  const StayReasons stays = doubts_of(8, 8 - 0.49 * kLimit, 0.875, 0.05);
  ASSERT_EQ(stays.size(), 1u);
  EXPECT_EQ(stays.begin()->first.geodetic, 0u);
  EXPECT_EQ(stays.begin()->second, StayReason::kTooLittleChecks);
  EXPECT_TRUE(doubts_of(8, 8 - 0.51 * kLimit, 0.875, 0.05).empty());
  EXPECT_TRUE(doubts_of(8, 8 - 0.49 * kLimit, 0.875, 0.05, kLimit + 0.1).empty());
  EXPECT_TRUE(doubts_of(8, 8 - 0.49 * kLimit, 0.875).empty());
}

TEST(Rivals, ImagePointsAreNone) {
  Block block = two_distances();
  block.observations = {{.image = {1}, .point = {1}, .pixel = {}}};
  TestedObservation ray{.group = ObservationGroup::kTieImages, .redundancy = 0.5, .w = 8, .suspicion = 8};
  const Reliability tests = tests_of({distance(0, 8), ray});
  EXPECT_TRUE(rivals_of(tests.suspects[0], tests, block).rivals.empty());
}

}  // namespace
}  // namespace collinea
