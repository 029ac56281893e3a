// SPDX-License-Identifier: Apache-2.0
#include "collinea/match/descriptors.h"

#include <gtest/gtest.h>

#include <hwy/targets.h>
#include <numeric>

#include "collinea/match/internal/descriptors_kernels.h"
#include "collinea/math/random.h"
#include "collinea/math/test_targets.h"

namespace collinea {
namespace {

std::vector<Descriptor> random_descriptors(std::size_t count, std::uint64_t seed, std::uint32_t values) {
  Random random(seed);
  std::vector<Descriptor> descriptors(count);
  for (Descriptor& descriptor : descriptors)
    for (std::uint8_t& value : descriptor) value = static_cast<std::uint8_t>(random.below(values));
  return descriptors;
}

std::int32_t squared_distance(const Descriptor& a, const Descriptor& b) {
  std::int32_t sum = 0;
  for (std::size_t k = 0; k < a.size(); ++k) sum += (int{a[k]} - int{b[k]}) * (int{a[k]} - int{b[k]});
  return sum;
}

NearestTwo by_definition(const Descriptor& query, const std::vector<Descriptor>& among) {
  NearestTwo nearest;
  for (std::uint32_t j = 0; j < among.size(); ++j) {
    const std::int32_t distance = squared_distance(query, among[j]);
    if (distance < nearest.best) {
      nearest.second = nearest.best;
      nearest.best = distance;
      nearest.index = j;
    } else if (distance < nearest.second) {
      nearest.second = distance;
    }
  }
  return nearest;
}

void expect_nearest_two_by_definition(const std::vector<Descriptor>& a, const std::vector<Descriptor>& b) {
  std::vector<NearestTwo> of_a(a.size()), of_b(b.size());
  nearest_two(a.empty() ? nullptr : a.front().data(), a.size(), b.empty() ? nullptr : b.front().data(), b.size(),
              of_a.data(), of_b.data());
  for (std::size_t i = 0; i < a.size(); ++i) ASSERT_EQ(of_a[i], by_definition(a[i], b)) << i << " of " << a.size();
  for (std::size_t j = 0; j < b.size(); ++j) ASSERT_EQ(of_b[j], by_definition(b[j], a)) << j << " of " << b.size();
}

// Every instruction set that this machine has and the library was built for.
class EveryTarget : public ::testing::TestWithParam<std::int64_t> {
 protected:
  testing::OnTarget target_{GetParam()};
};

INSTANTIATE_TEST_SUITE_P(Machine, EveryTarget, ::testing::ValuesIn(testing::processor_targets()),
                         [](const auto& instance) {
                           return std::string(hwy::TargetName(instance.param)) + "_" + std::to_string(instance.index);
                         });

TEST_P(EveryTarget, NearestTwoAgreeWithTheDefinitionForAllSizesAroundTheTiles) {
  for (const std::size_t count_a : {0, 1, 2, 3, 4, 5, 61})
    for (const std::size_t count_b : {0, 1, 2, 15, 16, 17, 63, 64, 65, 131})
      expect_nearest_two_by_definition(random_descriptors(count_a, count_a, 256),
                                       random_descriptors(count_b, 1000 + count_b, 256));
}

TEST_P(EveryTarget, NearestTwoAgreeWithTheDefinitionAcrossManyTiles) {
  expect_nearest_two_by_definition(random_descriptors(531, 1, 128), random_descriptors(277, 2, 128));
}

TEST_P(EveryTarget, OfEquallyNearOnesTheFirstIsTaken) {
  // Values 0 and 1 only: distances are small whole numbers and most minima are shared.
  auto a = random_descriptors(300, 3, 2), b = random_descriptors(150, 4, 2);
  b[77] = b[12] = b[11] = a[290] = a[5];
  expect_nearest_two_by_definition(a, b);
}

// Sets of seven bits may be multiplied in another way.
TEST_P(EveryTarget, TheLargestSevenBitsDoNotOverflow) {
  std::vector<Descriptor> a(5), b(20);
  a[0].fill(0);
  for (std::size_t i = 1; i < a.size(); ++i) a[i].fill(127);
  b[3].fill(127);
  b[4].fill(126);
  expect_nearest_two_by_definition(a, b);
  b[4][17] = 128;
  expect_nearest_two_by_definition(a, b);
  expect_nearest_two_by_definition(b, a);
}

TEST_P(EveryTarget, TheLargestBytesDoNotOverflow) {
  std::vector<Descriptor> a(5), b(20);
  for (Descriptor& descriptor : a) descriptor.fill(255);
  b[3].fill(255);
  b[4].fill(254);
  expect_nearest_two_by_definition(a, b);
}

TEST_P(EveryTarget, SquaredDistancesAgreeWithTheDefinition) {
  auto some = random_descriptors(9, 5, 256);
  some[3].fill(255);
  some[4].fill(0);
  const std::vector<std::uint32_t> which = {8, 0, 3, 4, 4, 7};
  for (const std::size_t i : {0, 3, 4}) {
    std::vector<std::int32_t> distances(which.size());
    squared_distances(some[i].data(), some.front().data(), which.data(), which.size(), distances.data());
    for (std::size_t k = 0; k < which.size(); ++k) EXPECT_EQ(distances[k], squared_distance(some[i], some[which[k]]));
  }
}

TEST_P(EveryTarget, DotProductsAgreeWithTheDefinition) {
  Random random(6);
  constexpr std::size_t kLength = 384, kCount = 7;
  std::vector<std::int8_t> one(kLength), all(kCount * kLength);
  for (auto* bytes : {&one, &all})
    for (std::int8_t& byte : *bytes) byte = static_cast<std::int8_t>(int(random.below(255)) - 127);
  std::fill_n(all.begin(), kLength, std::int8_t{-127});
  for (int round = 0; round < 2; ++round) {
    for (std::size_t count = 0; count <= kCount; ++count) {
      std::vector<std::int32_t> products(count + 1, 77);
      dot_products(one.data(), all.data(), kLength, count, products.data());
      for (std::size_t k = 0; k < count; ++k)
        EXPECT_EQ(products[k],
                  std::inner_product(one.begin(), one.end(), all.begin() + std::ptrdiff_t(k * kLength), 0));
      EXPECT_EQ(products[count], 77);
    }
    one.assign(kLength, std::int8_t{-127});
  }
}

Descriptor unit_with(std::size_t dimension, std::uint8_t value, std::size_t other = 0, std::uint8_t other_value = 0) {
  Descriptor descriptor{};
  descriptor[other] = other_value;
  descriptor[dimension] = value;
  return descriptor;
}

TEST(MatchDescriptors, NoDescriptorsGiveNoMatches) {
  const auto some = random_descriptors(3, 1, 256);
  EXPECT_TRUE(match_descriptors({}, some, {}).empty());
  EXPECT_TRUE(match_descriptors(some, {}, {}).empty());
}

TEST(MatchDescriptors, OneAgainstOneIsDecidedByTheDistanceAlone) {
  const std::vector<Descriptor> a{unit_with(0, 200)}, near{unit_with(0, 190)}, far{unit_with(1, 255, 2, 255)};
  EXPECT_EQ(match_descriptors(a, near, {}), (std::vector<Match>{{0, 0}}));
  EXPECT_EQ(match_descriptors(a, far, {.max_distance = 2}), (std::vector<Match>{{0, 0}}));
  EXPECT_TRUE(match_descriptors(a, far, {.max_distance = 0.5}).empty());
}

TEST(MatchDescriptors, TheRatioIsTestedOnDistancesInBothDirections) {
  // Distances from a: 70 to the first and 100 to the second of b.
  const std::vector<Descriptor> a{unit_with(0, 0)}, b{unit_with(1, 100), unit_with(2, 70)};
  EXPECT_EQ(match_descriptors(a, b, {.max_ratio = 0.701}), (std::vector<Match>{{0, 1}}));
  EXPECT_TRUE(match_descriptors(a, b, {.max_ratio = 0.699}).empty());
  EXPECT_EQ(match_descriptors(b, a, {.max_ratio = 0.701}), (std::vector<Match>{{1, 0}}));
  EXPECT_TRUE(match_descriptors(b, a, {.max_ratio = 0.699}).empty());
}

TEST(MatchDescriptors, TwoEquallyNearOnesAreNoMatch) {
  const std::vector<Descriptor> a{unit_with(0, 100), unit_with(5, 200)};
  const std::vector<Descriptor> b{unit_with(0, 100), unit_with(5, 200), unit_with(0, 100)};
  EXPECT_EQ(match_descriptors(a, b, {}), (std::vector<Match>{{1, 1}}));
}

TEST(MatchDescriptors, OnlyMutualNeighboursMatch) {
  // The nearest of both is b 0, whose nearest is a 1.
  const std::vector<Descriptor> a{unit_with(0, 60), unit_with(0, 95)}, b{unit_with(0, 100), unit_with(9, 255)};
  EXPECT_EQ(match_descriptors(a, b, {}), (std::vector<Match>{{1, 0}}));
}

TEST(MatchDescriptors, NoisyCopiesInAnotherOrderAreAllFound) {
  const auto a = random_descriptors(200, 8, 90);
  std::vector<Descriptor> b(a.rbegin(), a.rend());
  Random random(9);
  for (Descriptor& descriptor : b)
    for (std::uint8_t& value : descriptor) value = static_cast<std::uint8_t>(value + random.below(9));
  const auto matches = match_descriptors(a, b, {});
  ASSERT_EQ(matches.size(), 200u);
  for (const auto& [i, j] : matches) EXPECT_EQ(i + j, 199u);
}

}  // namespace
}  // namespace collinea
