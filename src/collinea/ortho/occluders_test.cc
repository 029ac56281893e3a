// SPDX-License-Identifier: Apache-2.0
#include "collinea/ortho/occluders.h"

#include <gtest/gtest.h>

#include <cmath>

#include "collinea/math/random.h"

namespace collinea {
namespace {

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

FloatImage flat_with_tower() {
  FloatImage heights(100, 100, 1, 5);
  for (int y = 40; y < 60; ++y)
    for (int x = 40; x < 60; ++x) heights.at(x, y) = 25;
  return heights;
}

// A tower of 20 m at 1 m cells, the camera 45 degrees above the horizon far in the west: its shadow is 20 m long.
TEST(Occluders, ATowerHidesWhatLiesBehindIt) {
  const FloatImage heights = flat_with_tower();
  const Occluders occluders(heights, 0, 0, 1);
  const auto hidden = [&](double x, double y) {
    return occluders.hide(x, y, double(heights.at(int(x), int(y))), x - 1000, y, 1005);
  };
  EXPECT_TRUE(hidden(62.5, 50.5));
  EXPECT_TRUE(hidden(77.5, 50.5));
  EXPECT_FALSE(hidden(81.5, 50.5));
  EXPECT_FALSE(hidden(38.5, 50.5));
  EXPECT_FALSE(hidden(50.5, 50.5));
  EXPECT_FALSE(hidden(65.5, 30.5));
  EXPECT_TRUE(occluders.hide(38.5, 50.5, 5, 1000, 50.5, 900));  // from the other side
}

// What may be lower than it seems hides less, down to ten cells: of the shadow of 20 m, 14 m with a sigma of 2 m, and
// half with a sigma beyond all use.
TEST(Occluders, AnUncertainTowerHidesLess) {
  const auto hidden = [&](float sigma_m, double x) {
    const Occluders occluders(flat_with_tower(), 0, 0, 1, FloatImage(100, 100, 1, sigma_m));
    return occluders.hide(x, 50.5, 5, x - 1000, 50.5, 1005);
  };
  EXPECT_TRUE(hidden(2, 71.5));
  EXPECT_FALSE(hidden(2, 75.5));
  EXPECT_TRUE(hidden(50, 67.5));
  EXPECT_FALSE(hidden(50, 71.5));
}

TEST(Occluders, ThinThingsAreStatedFromWideOnes) {
  FloatImage heights = flat_with_tower();
  for (int y = 40; y < 60; ++y)
    for (int x = 84; x < 88; ++x) heights.at(x, y) = 25;  // a wall of four cells
  const Occluders occluders(heights, 0, 0, 1);
  const auto wide = [&](double x) { return occluders.wide_ones_hide(x, 50.5, 5, x - 1000, 50.5, 1005); };
  EXPECT_TRUE(occluders.hide(90.5, 50.5, 5, 90.5 - 1000, 50.5, 1005));
  EXPECT_FALSE(wide(90.5));
  EXPECT_TRUE(wide(65.5));
}

HeightField field_of(const FloatImage& heights_m, double sigma_m = 0) {
  HeightField field;
  field.grid = {0, 0, 1, heights_m.width, heights_m.height, ""};
  field.read = [&](int column, int row, int width, int height) -> Result<FloatImage> {
    FloatImage part(width, height);
    for (int y = 0; y < height; ++y) std::copy_n(heights_m.row(row + y) + column, width, part.row(y));
    return part;
  };
  if (sigma_m > 0)
    field.read_sigma = [sigma_m](int, int, int width, int height) -> Result<FloatImage> {
      return FloatImage(width, height, 1, float(sigma_m));
    };
  return field;
}

// Those around an area of a surface, everything of which may hide it.
Occluders around(const HeightField& field, int first_column, int last_column, int first_row, int last_row) {
  const auto down = [](int cell) { return std::max(0, cell - Occluders::kNear - kBesides) / 16 * 16; };
  const auto up = [](int cell, int most) {
    return std::min(most, (cell + Occluders::kNear + kBesides) / 16 * 16 + 16);
  };
  CellArea near{down(first_column), down(first_row), 0, 0};
  near.width = up(last_column, field.grid.width) - near.column;
  near.height = up(last_row, field.grid.height) - near.row;
  const auto blocks = [](int cells) { return (cells + HeightOverview::kBlock - 1) / HeightOverview::kBlock; };
  const SurfaceBlocks far{0, 0, Raster<std::uint8_t>(blocks(field.grid.width), blocks(field.grid.height), 1, 1)};
  return occluders_of(field, field.read(near.column, near.row, near.width, near.height).value(), near, far).value();
}

// True when the point of a level surface at 0 is hidden from far in the east, the line of sight rising so many cells
// per cell.
bool hidden_from_the_east(const Occluders& occluders, double x, double y, double rise, bool by_wide_things = false) {
  const double u = x - occluders.column(), v = y - occluders.row();
  return by_wide_things ? occluders.wide_ones_hide(u, v, 0, u + 5000, v, 5000 * rise)
                        : occluders.hide(u, v, 0, u + 5000, v, 5000 * rise);
}

FloatImage plain_with_tower(int first, int wide, float height_m, int from_row = 40, int rows = 20) {
  FloatImage heights(1300, 100);
  for (int y = from_row; y < from_row + rows; ++y)
    for (int x = first; x < first + wide; ++x) heights.at(x, y) = height_m;
  return heights;
}

// 600 cells high, 400 away: lines of sight through its top rise by 1.5.
TEST(Occluders, ATowerFarAwayHidesUpToItsTop) {
  const FloatImage heights = plain_with_tower(450, 20, 600);
  const Occluders occluders = around(field_of(heights), 20, 80, 30, 70);
  EXPECT_TRUE(hidden_from_the_east(occluders, 50, 50, 1.45));
  EXPECT_FALSE(hidden_from_the_east(occluders, 50, 50, 1.53));
  EXPECT_FALSE(hidden_from_the_east(occluders, 50, 30, 1.45));  // it stands beside the line
  EXPECT_GE(occluders.ceiling_m(460, 50), 600);
  EXPECT_GE(occluders.highest_m(), 600);
}

// Three sigmas lower.
TEST(Occluders, AnUncertainTowerFarAwayHidesLess) {
  const FloatImage heights = plain_with_tower(450, 20, 600);
  const Occluders occluders = around(field_of(heights, 2), 20, 80, 30, 70);
  EXPECT_TRUE(hidden_from_the_east(occluders, 50, 50, 1.45));
  EXPECT_FALSE(hidden_from_the_east(occluders, 50, 50, 1.51));
  EXPECT_TRUE(hidden_from_the_east(around(field_of(heights), 20, 80, 30, 70), 50, 50, 1.48));
}

// From where lines of sight are followed in cells of the surface on to where they are in larger ones: nowhere is there
// a gap through which a thing is overlooked, nor anything that is not there.
TEST(Occluders, NothingIsOverlookedWhereNearTurnsIntoFar) {
  const FloatImage heights = plain_with_tower(400, 4, 300);
  const Occluders occluders = around(field_of(heights), 20, 380, 30, 70);
  for (double x = 100; x < 300; x += 0.7) {
    EXPECT_TRUE(hidden_from_the_east(occluders, x, 50, 290 / (404 - x))) << x;
    EXPECT_FALSE(hidden_from_the_east(occluders, x, 50, 303 / (396 - x))) << x;
  }
}

// A mast of one cell, which begins in the middle of a coarse cell, gets as wide as that, and is no wide thing.
TEST(Occluders, AMastFarAwayIsSeenAndNoWiderThanACoarseCell) {
  const FloatImage heights = plain_with_tower(450, 1, 600, 50, 1);
  const Occluders occluders = around(field_of(heights), 20, 80, 30, 70);
  for (const double x : {49.5, 50.5, 51.5, 52.5}) {
    EXPECT_TRUE(hidden_from_the_east(occluders, x, 50.5, 1.4));
    EXPECT_FALSE(hidden_from_the_east(occluders, x, 50.5, 1.4, true));
    for (const double aside : {46.5, 54.5}) EXPECT_FALSE(hidden_from_the_east(occluders, x, aside, 1.4));
  }
}

// More than four cells both ways are wide, far away as nearby and however they lie to the coarse cells.
TEST(Occluders, WideThingsFarAwayAreThoseThatAreWideNearby) {
  for (int first = 450; first < 454; ++first) {
    for (const int wide : {4, 5}) {
      const FloatImage heights = plain_with_tower(first, wide, 600);
      const HeightField field = field_of(heights);
      const Occluders far = around(field, 20, 80, 30, 70), near = around(field, 380, 420, 30, 70);
      EXPECT_EQ(hidden_from_the_east(far, 50, 50, 1.3, true), wide == 5) << first;
      EXPECT_EQ(hidden_from_the_east(near, 400, 50, 7, true), wide == 5) << first;
      EXPECT_TRUE(hidden_from_the_east(far, 50, 50, 1.3)) << first;
    }
  }
}

// Mountains with holes. What a point is hidden from is the same whatever window it lies in, and nearly the same as if
// all were known in full: coarse cells hide a little more.
TEST(Occluders, TheWindowDoesNotMatter) {
  FloatImage heights(1500, 700);
  for (int y = 0; y < heights.height; ++y)
    for (int x = 0; x < heights.width; ++x)
      heights.at(x, y) =
          float(std::max(0.0, 300 * std::sin(0.006 * x) * std::cos(0.005 * y)) + 7 * ((x / 9 + y / 7) % 2));
  Random random(5);
  for (int i = 0; i < 300; ++i) heights.at(int(random.uniform(0, 1500)), int(random.uniform(0, 700))) = kNone;
  const HeightField field = field_of(heights);
  const Occluders one = around(field, 300, 500, 200, 400), other = around(field, 380, 700, 150, 420);
  const Occluders full(heights, 0, 0, 1);
  int samples = 0, hidden = 0, more = 0, less = 0;
  for (int i = 0; i < 4000; ++i) {
    const double x = random.uniform(380, 500), y = random.uniform(200, 400);
    const float z = heights.at(int(x), int(y));
    if (std::isnan(z)) continue;
    const double direction = random.uniform(0, 6.283), run = random.uniform(300, 900);
    const double camera_x = x + run * std::cos(direction), camera_y = y + run * std::sin(direction);
    const double camera_m = double(z) + run * random.uniform(0.1, 0.9);
    const auto hides = [&](const Occluders& from) {
      return from.hide(x - from.column(), y - from.row(), double(z), camera_x - from.column(), camera_y - from.row(),
                       camera_m);
    };
    EXPECT_EQ(hides(one), hides(other)) << x << ' ' << y;
    ++samples, hidden += hides(full);
    more += hides(one) && !hides(full), less += hides(full) && !hides(one);
  }
  EXPECT_GT(hidden, samples / 10);
  EXPECT_LT(hidden, 3 * samples / 4);
  EXPECT_LE(more, samples / 50);
  EXPECT_LE(less, samples / 500);
}

}  // namespace
}  // namespace collinea
