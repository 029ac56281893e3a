// SPDX-License-Identifier: Apache-2.0
#include "collinea/surface/internal/ground_filter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "collinea/math/random.h"

namespace collinea {
namespace {

constexpr int kSide = 120;
constexpr double kCell = 0.5, kLargest = 30;
using Height = std::function<double(int x, int y)>;

FloatImage raster(const Height& height_m) {
  FloatImage heights(kSide, kSide);
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) heights.at(x, y) = float(height_m(x, y));
  return heights;
}

Raster<std::uint8_t> ground(const Height& height_m, int threads = 1) {
  Run run;
  run.threads = threads;
  return ground_cells(raster(height_m), kCell, kLargest, run);
}

std::size_t not_ground(const Raster<std::uint8_t>& cells) {
  return std::size_t(std::count(cells.data.begin(), cells.data.end(), std::uint8_t{0}));
}

bool within(int x, int y, int left, int top, int size) {
  return x >= left && y >= top && x < left + size && y < top + size;
}

TEST(GroundFilter, WindowsAgreeWithPlainLoops) {
  Random random(3);
  FloatImage heights(37, 23);
  for (float& h : heights.data) h = float(random.normal());
  for (const int r : {1, 2, 5, 30}) {
    const FloatImage low = smallest_around(heights, r, {}), high = largest_around(heights, r, {});
    for (int y = 0; y < heights.height; ++y)
      for (int x = 0; x < heights.width; ++x) {
        float least = heights.at(x, y), most = least;
        for (int v = std::max(0, y - r); v <= std::min(heights.height - 1, y + r); ++v)
          for (int u = std::max(0, x - r); u <= std::min(heights.width - 1, x + r); ++u) {
            least = std::min(least, heights.at(u, v));
            most = std::max(most, heights.at(u, v));
          }
        ASSERT_EQ(low.at(x, y), least);
        ASSERT_EQ(high.at(x, y), most);
      }
  }
}

// Flat, a slope of 31 degrees, and a hill of 5 m that squares of 30 m cut off: all of it is ground.
TEST(GroundFilter, WhatHasNoObjectsIsGround) {
  for (const Height& height :
       {Height([](int, int) { return 300; }), Height([](int x, int) { return 0.3 * x; }),
        Height([](int x, int y) { return 5 * std::exp(-(std::pow(x - 60, 2) + std::pow(y - 60, 2)) / 400.0); })})
    EXPECT_EQ(not_ground(ground(height)), 0u);
}

// A house of 10 m x 10 m, 4 m high, and a car of 2 m x 2 m, 1.5 m high, on a slope of 14 degrees.
TEST(GroundFilter, ObjectsGoAndNothingElse) {
  const auto object = [](int x, int y) { return within(x, y, 30, 40, 20) || within(x, y, 80, 80, 4); };
  const auto cells = ground([&](int x, int y) {
    return 0.125 * x + (within(x, y, 30, 40, 20) ? 4 : 0) + (within(x, y, 80, 80, 4) ? 1.5 : 0);
  });
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) EXPECT_EQ(cells.at(x, y) == 0, object(x, y)) << x << ' ' << y;
}

TEST(GroundFilter, WhatIsWiderThanTheLargestObjectIsGround) {
  const auto plateau = [](int x, int y) { return within(x, y, 20, 20, 70) ? 3.0 : 0.0; };  // 35 m
  EXPECT_EQ(not_ground(ground(plateau)), 0u);
}

TEST(GroundFilter, HolesInTheSurfaceAndWrongDepthsAreNoGround) {
  const auto cells = ground([](int x, int y) {
    if (within(x, y, 10, 10, 8)) return std::numeric_limits<double>::quiet_NaN();
    return x == 60 && y == 60 ? -5.0 : 0.0;
  });
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x)
      EXPECT_EQ(cells.at(x, y) == 0, within(x, y, 10, 10, 8) || (x == 60 && y == 60)) << x << ' ' << y;
}

TEST(GroundFilter, ThreadsDoNotMatter) {
  const auto rough = [](int x, int y) { return std::sin(0.3 * x) * std::cos(0.2 * y) * ((x * 7 + y * 13) % 11); };
  EXPECT_EQ(ground(rough, 1).data, ground(rough, 3).data);
}

TEST(GroundFilter, NothingKnownIsNoGround) {
  EXPECT_EQ(not_ground(ground([](int, int) { return std::numeric_limits<double>::quiet_NaN(); })),
            std::size_t(kSide) * kSide);
}

}  // namespace
}  // namespace collinea
