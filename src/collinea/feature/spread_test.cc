// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/spread.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "collinea/base/random.h"

namespace collinea {
namespace {

// Nine tenths of the spots, all the strong ones, lie in the left half.
std::vector<Spot> uneven_spots() {
  Random random(1);
  std::vector<Spot> spots;
  for (int i = 0; i < 5000; ++i) {
    const bool left = i % 10 != 0;
    spots.push_back({static_cast<float>(random.uniform(left ? 0 : 500, left ? 500 : 1000)),
                     static_cast<float>(random.uniform(0, 600)),
                     static_cast<float>(left ? random.uniform(0.5, 1) : random.uniform(0, 0.5))});
  }
  return spots;
}

long on_the_right(const std::vector<Spot>& spots, const std::vector<std::uint32_t>& order, std::ptrdiff_t first) {
  return std::count_if(order.begin(), order.begin() + first, [&](std::uint32_t i) { return spots[i].x > 500; });
}

TEST(SpreadOrder, WithoutAnEvenShareTheStrongestComeFirst) {
  const auto spots = uneven_spots();
  const auto order = spread_order(spots, 1000, 600, 400, 0);
  EXPECT_EQ(on_the_right(spots, order, 400), 0);
  for (std::size_t i = 1; i < 400; ++i) EXPECT_GE(spots[order[i - 1]].strength, spots[order[i]].strength);
}

TEST(SpreadOrder, TheEvenShareFillsThePoorRegions) {
  const auto spots = uneven_spots();
  EXPECT_NEAR(on_the_right(spots, spread_order(spots, 1000, 600, 400, 1), 400), 200, 12);
  // Half are the strongest, all on the left; the others go where there are none yet.
  EXPECT_NEAR(on_the_right(spots, spread_order(spots, 1000, 600, 400, 0.5), 400), 180, 40);
}

TEST(SpreadOrder, EverySpotIsThereOnce) {
  const auto spots = uneven_spots();
  for (const int wanted : {0, 1, 300, 4999, 5000, 6000}) {
    auto order = spread_order(spots, 1000, 600, wanted, 0.5);
    std::ranges::sort(order);
    ASSERT_EQ(order.size(), spots.size());
    for (std::uint32_t i = 0; i < order.size(); ++i) ASSERT_EQ(order[i], i);
  }
  EXPECT_TRUE(spread_order({}, 1000, 600, 10, 0.5).empty());
}

}  // namespace
}  // namespace collinea
