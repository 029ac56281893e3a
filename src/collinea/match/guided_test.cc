// SPDX-License-Identifier: Apache-2.0
#include "collinea/match/descriptors.h"

#include <gtest/gtest.h>

#include <numeric>

#include "collinea/math/random.h"

namespace collinea {
namespace {

std::vector<Descriptor> random_descriptors(std::size_t count, std::uint64_t seed) {
  Random random(seed);
  std::vector<Descriptor> descriptors(count);
  for (Descriptor& descriptor : descriptors)
    for (std::uint8_t& value : descriptor) value = static_cast<std::uint8_t>(random.below(90));
  return descriptors;
}

std::vector<Descriptor> slightly_changed(std::vector<Descriptor> descriptors, std::uint64_t seed) {
  Random random(seed);
  for (Descriptor& descriptor : descriptors)
    for (std::uint8_t& value : descriptor) value = static_cast<std::uint8_t>(value + random.below(12));
  return descriptors;
}

struct Everything {
  std::vector<std::uint32_t> begin, candidates;

  Everything(std::size_t count_a, std::size_t count_b) {
    for (std::size_t i = 0; i <= count_a; ++i) begin.push_back(static_cast<std::uint32_t>(i * count_b));
    candidates.resize(count_a * count_b);
    for (std::size_t k = 0; k < candidates.size(); ++k) candidates[k] = static_cast<std::uint32_t>(k % count_b);
  }
};

TEST(MatchAmong, AllCandidatesGiveWhatTheFullSearchGives) {
  const auto a = random_descriptors(150, 1);
  auto b = slightly_changed(a, 2);
  b.resize(120);
  b.push_back(b[7]);  // two equally near: no match for 7
  const Everything all(a.size(), b.size());
  const auto matches = match_among(a, b, all.begin, all.candidates, {});
  EXPECT_EQ(matches, match_descriptors(a, b, {}));
  EXPECT_EQ(matches.size(), 119u);
}

TEST(MatchAmong, ARivalThatIsNoCandidateDoesNotCount) {
  const auto a = random_descriptors(1, 3);
  const auto other = random_descriptors(1, 4);
  const std::vector<Descriptor> b = {a[0], a[0], other[0]};
  EXPECT_TRUE(match_descriptors(a, b, {}).empty());
  const std::vector<std::uint32_t> begin = {0, 2}, candidates = {2, 1};
  EXPECT_EQ(match_among(a, b, begin, candidates, {}), (std::vector<Match>{{0, 1}}));
}

TEST(MatchAmong, TheRatioTestAlsoLooksFromTheOtherSide) {
  const auto twice = random_descriptors(1, 5);
  const std::vector<Descriptor> a = {twice[0], twice[0]}, b = {twice[0]};
  const std::vector<std::uint32_t> begin = {0, 1, 2}, candidates = {0, 0};
  EXPECT_TRUE(match_among(a, b, begin, candidates, {}).empty());
}

TEST(MatchAmong, ALonelyCandidateMustBeatOneAtTheLargestDistance) {
  Descriptor zero{}, one{};
  one[0] = 200;  // a distance of 200 / 512 = 0.39
  const std::vector<Descriptor> a = {zero}, b = {one};
  const std::vector<std::uint32_t> begin = {0, 1}, candidates = {0};
  EXPECT_EQ(match_among(a, b, begin, candidates, {.max_ratio = 0.8, .max_distance = 0.5}).size(), 1u);
  EXPECT_EQ(match_among(a, b, begin, candidates, {.max_ratio = 0.8, .max_distance = 0.45}).size(), 0u);
}

TEST(MatchAmong, NoCandidatesNoMatches) {
  const auto a = random_descriptors(2, 6);
  const std::vector<std::uint32_t> begin = {0, 0, 0};
  EXPECT_TRUE(match_among(a, a, begin, {}, {}).empty());
  EXPECT_TRUE(match_among({}, {}, std::vector<std::uint32_t>{0}, {}, {}).empty());
}

}  // namespace
}  // namespace collinea
