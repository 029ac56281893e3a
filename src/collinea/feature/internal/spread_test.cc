// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/internal/spread.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <numeric>

#include "collinea/math/random.h"

namespace collinea {
namespace {

// Nine tenths of the spots lie in the left half, with strengths of 0.75 to 1; those of the right are weaker.
std::vector<Spot> uneven_spots(double weakest, double strongest) {
  Random random(1);
  std::vector<Spot> spots;
  for (int i = 0; i < 5000; ++i) {
    const bool left = i % 10 != 0;
    spots.push_back({static_cast<float>(random.uniform(left ? 0 : 500, left ? 500 : 1000)),
                     static_cast<float>(random.uniform(0, 600)),
                     static_cast<float>(left ? random.uniform(0.75, 1) : random.uniform(weakest, strongest))});
  }
  return spots;
}

// How many of the `wanted` strongest beside their region lie in the right half.
long on_the_right(const std::vector<Spot>& spots, int wanted, double evenness) {
  const std::vector<float> strengths = regional_strengths(spots, 1000, 600, wanted, evenness);
  std::vector<std::size_t> order(spots.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, std::ranges::greater{}, [&](std::size_t i) { return strengths[i]; });
  return std::count_if(order.begin(), order.begin() + wanted, [&](std::size_t i) { return spots[i].x > 500; });
}

// Wanted are 16 of the 360 spots of a region on the left (0.99) and 16 of 40 on the right (0.74). Where the halves meet
// the threshold lies between, which favours the left.
TEST(RegionalStrengths, EvennessFillsThePoorRegions) {
  const auto spots = uneven_spots(0.5, 0.9);
  const long half = on_the_right(spots, 400, 0.5), all = on_the_right(spots, 400, 1);
  EXPECT_EQ(on_the_right(spots, 400, 0), 0);
  EXPECT_GT(half, 20);
  EXPECT_LT(half, 80);
  EXPECT_GT(all, 140);
  EXPECT_LT(all, 220);
}

TEST(RegionalStrengths, WhatIsMuchWeakerIsLeftOut) { EXPECT_EQ(on_the_right(uneven_spots(0, 0.3), 400, 1), 0); }

// The order within a region is that of the strengths: its spots are compared with much the same threshold.
TEST(RegionalStrengths, NearbySpotsKeepTheirOrder) {
  auto spots = uneven_spots(0.5, 0.9);
  spots.push_back({700, 300, 0.61f});
  spots.push_back({701, 300, 0.60f});
  const auto strengths = regional_strengths(spots, 1000, 600, 400, 1);
  EXPECT_GT(strengths[5000], strengths[5001]);
}

TEST(RegionalStrengths, FewSpotsOrNoneWantedAreNoMatter) {
  EXPECT_TRUE(regional_strengths({}, 1000, 600, 10, 0.5).empty());
  const auto spots = uneven_spots(0.5, 0.9);
  for (const int wanted : {-1, 0, 1, 3, 5000, 6000})
    for (const float s : regional_strengths(spots, 1000, 600, wanted, 1)) EXPECT_TRUE(s > 0 && s <= 2);
  const std::vector<Spot> flat(50, Spot{10, 10, 0});
  for (const float s : regional_strengths(flat, 1000, 600, 10, 0.5)) EXPECT_EQ(s, 0);
}

}  // namespace
}  // namespace collinea
