// SPDX-License-Identifier: Apache-2.0
#include "collinea/ortho/seamlines.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "collinea/math/random.h"

namespace collinea {
namespace {

const MapGrid kGrid{500'000.3, 5'300'000.7, 0.21, 24, 17, ""};

Raster<std::uint16_t> random_sources(Random& random, int most) {
  Raster<std::uint16_t> source(kGrid.width, kGrid.height);
  for (auto& cell : source.data) cell = std::uint16_t(random.uniform(0, most + 0.999));
  return source;
}

double area_of(const MapRing& ring) {
  double twice = 0;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Eigen::Vector2d a = ring[i] - ring[0], b = ring[(i + 1) % ring.size()] - ring[0];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return twice / 2;
}

// On a grid of the plan and on one four times as fine: what is filled is what was outlined.
TEST(Seamlines, FillingTheOutlinesGivesTheCellsBack) {
  Random random(5);
  for (int trial = 0; trial < 40; ++trial) {
    const auto source = random_sources(random, 1 + trial % 4);
    const auto polygons = outlines_of(source, kGrid);
    Raster<std::uint16_t> filled(kGrid.width, kGrid.height), below = filled;
    fill(polygons, kGrid, 0, 0, filled, below);
    EXPECT_EQ(below.data, std::vector<std::uint16_t>(below.data.size()));
    ASSERT_EQ(filled.data, source.data) << trial;
    MapGrid fine = kGrid;
    fine.cell_m /= 4;
    Raster<std::uint16_t> part(30, 20);  // from a cell beside the grid on
    below = part;
    fill(polygons, fine, -3, 8, part, below);
    for (int y = 0; y < part.height; ++y)
      for (int x = 0; x < part.width; ++x)
        ASSERT_EQ(part.at(x, y), x < 3 ? 0 : source.at((x - 3) / 4, (y + 8) / 4)) << trial << ' ' << x << ' ' << y;
  }
}

TEST(Seamlines, OutlinesAreClockwiseHolesAreNotAndNoRingMeetsItself) {
  Random random(6);
  for (int trial = 0; trial < 40; ++trial) {
    for (const SeamPolygon& polygon : outlines_of(random_sources(random, 1 + trial % 3), kGrid)) {
      ASSERT_FALSE(polygon.rings.empty());
      for (std::size_t i = 0; i < polygon.rings.size(); ++i) {
        EXPECT_EQ(area_of(polygon.rings[i]) < 0, i == 0);
        std::set<std::pair<double, double>> corners;
        for (const auto& corner : polygon.rings[i])
          EXPECT_TRUE(corners.emplace(corner.x(), corner.y()).second) << "a ring meets itself";
      }
    }
  }
}

TEST(Seamlines, SmallAreasGoToTheNeighbourWithTheLongestBorder) {
  Raster<std::uint16_t> source(8, 4, 1, 5);
  for (int y = 0; y < 4; ++y) source.at(7, y) = 9, source.at(6, y) = 0;
  source.at(2, 1) = source.at(2, 2) = 7;     // among fives
  source.at(0, 3) = 4, source.at(1, 3) = 4;  // in a corner
  source.at(5, 0) = 6, source.at(4, 0) = 3, source.at(4, 1) = 3,
               source.at(5, 1) = 3;  // six: three on two sides, then nothing
  absorb_small_areas(3, source);
  for (int y = 0; y < 4; ++y) {
    for (int x = 0; x < 8; ++x) {
      const bool threes = (x == 4 || x == 5) && y < 2;
      EXPECT_EQ(source.at(x, y), x == 7 ? 9 : x == 6 ? 0 : threes ? 3 : 5) << x << ' ' << y;
    }
  }
  Raster<std::uint16_t> alone(3, 3);
  alone.at(1, 1) = 2;
  absorb_small_areas(3, alone);
  EXPECT_EQ(alone.at(1, 1), 2);
}

TEST(Seamlines, SmallAreasThatTouchLeaveNothingBehind) {
  Raster<std::uint16_t> source(10, 10);
  for (int y = 0; y < 10; ++y)
    for (int x = 0; x < 10; ++x) source.at(x, y) = 3;
  source.at(4, 4) = 2;  // takes what goes after it
  source.at(5, 4) = source.at(5, 5) = source.at(4, 5) = source.at(3, 5) = 1;
  absorb_small_areas(6, source);
  EXPECT_EQ(std::count(source.data.begin(), source.data.end(), 3), 100);
}

TEST(Seamlines, TheLaterPolygonLiesOnTop) {
  const MapGrid grid{0, 10, 1, 10, 10, ""};
  const auto square = [](double low, double high) {
    return MapRing{{low, low}, {low, high}, {high, high}, {high, low}};
  };
  Raster<std::uint16_t> filled(10, 10), below = filled;
  fill({{7, {square(1, 9), square(3, 5)}}, {8, {square(4, 8)}}}, grid, 0, 0, filled, below);
  EXPECT_EQ(below.at(7, 2), 7);
  EXPECT_EQ(below.at(4, 5), 0);
  EXPECT_EQ(below.at(8, 2), 0);
  EXPECT_EQ(filled.at(0, 5), 0);
  EXPECT_EQ(filled.at(1, 5), 7);
  EXPECT_EQ(filled.at(3, 6), 0);  // the hole, at 3.5 east, 3.5 north
  EXPECT_EQ(filled.at(4, 5), 8);  // over the hole
  EXPECT_EQ(filled.at(7, 2), 8);
  EXPECT_EQ(filled.at(8, 2), 7);
}

}  // namespace
}  // namespace collinea
