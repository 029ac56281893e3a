// SPDX-License-Identifier: Apache-2.0
#include "collinea/surface/internal/hole_filling.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>

#include "collinea/base/test_folder.h"
#include "collinea/math/random.h"
#include "collinea/surface/internal/measured_tiles.h"

namespace collinea {
namespace {

constexpr double kCell = 0.1;
constexpr float kSigma = 0.02f;
constexpr int kRim = HoleFilling::kRim;

using Height = std::function<double(int column, int row)>;  // NaN: not measured

SurfaceTile measured(const CellWindow& window, const Height& height_m) {
  SurfaceTile tile(window.width, window.height);
  for (int y = 0; y < window.height; ++y) {
    for (int x = 0; x < window.width; ++x) {
      const double z = height_m(int(window.column) + x, int(window.row) + y);
      if (std::isnan(z)) continue;
      tile.height_m.at(x, y) = float(z);
      tile.sigma_m.at(x, y) = kSigma;
      tile.state.at(x, y) = std::uint8_t(CellState::kMeasured);
      tile.count.at(x, y) = 5;
    }
  }
  return tile;
}

// A model of kSide x kSide cells from (kFirst, kFirst) on, shown to the filling in squares of `square` cells.
constexpr int kFirst = -37, kSide = 300;

HoleFilling prepared(const Height& height_m, int widest, int square = 64) {
  HoleFilling holes(kFirst, kFirst, kSide, kSide, kCell, widest);
  for (int row = -64; row < kFirst + kSide; row += square) {
    for (int column = -64; column < kFirst + kSide; column += square) {
      const CellWindow inside{column, row, square, square};
      holes.add(measured({column - kRim, row - kRim, square + 2 * kRim, square + 2 * kRim}, height_m), inside);
    }
  }
  holes.prepare();
  return holes;
}

SurfaceTile window_of(const HoleFilling& holes, const Height& height_m, const CellWindow& window) {
  return holes.filled(measured(HoleFilling::with_margin(window), height_m), window);
}

SurfaceTile filled(const Height& height_m, int widest) {
  return window_of(prepared(height_m, widest), height_m, {kFirst, kFirst, kSide, kSide});
}

bool in_block(int column, int row) {
  return column >= kFirst && row >= kFirst && column < kFirst + kSide && row < kFirst + kSide;
}

Height with_hole(const Height& height_m, const std::function<bool(int, int)>& hole) {
  return [=](int column, int row) {
    return in_block(column, row) && !hole(column, row) ? height_m(column, row) : std::nan("");
  };
}

CellState state(const SurfaceTile& tile, int column, int row) {
  return CellState(tile.state.at(column - kFirst, row - kFirst));
}
double height(const SurfaceTile& tile, int column, int row) {
  return double(tile.height_m.at(column - kFirst, row - kFirst));
}

std::size_t cells(const SurfaceTile& tile, CellState wanted) {
  return std::size_t(std::count(tile.state.data.begin(), tile.state.data.end(), std::uint8_t(wanted)));
}

TEST(HoleFilling, AHoleInsideIsFilledAsAWholeAndAWiderOneIsNot) {
  const auto disc = [](int x, int y) { return std::hypot(x - 110, y - 110) < 50; };
  const Height flat = with_hole([](int, int) { return 2.0; }, disc);
  const SurfaceTile tile = filled(flat, 100);
  EXPECT_EQ(cells(tile, CellState::kEmpty), 0u);
  for (const float z : tile.height_m.data) ASSERT_NEAR(z, 2, 1e-6);
  EXPECT_EQ(state(tile, 110, 110), CellState::kInterpolated);
  EXPECT_EQ(tile.count.at(110 - kFirst, 110 - kFirst), 0);
  const SurfaceTile left = filled(flat, 60);
  EXPECT_LT(cells(left, CellState::kInterpolated), 4000u);  // of 7850: no more than a hem
  EXPECT_EQ(state(left, 110, 110), CellState::kEmpty);
}

TEST(HoleFilling, MeasuredCellsStayAsTheyAre) {
  const Height hills = with_hole([](int x, int y) { return std::sin(0.1 * x) + 0.3 * std::cos(0.07 * y); },
                                 [](int x, int y) { return (x * 7 + y * 13) % 5 == 0; });
  const SurfaceTile tile = filled(hills, 250);
  for (int y = kFirst; y < kFirst + kSide; ++y)
    for (int x = kFirst; x < kFirst + kSide; ++x)
      if (!std::isnan(hills(x, y))) {
        ASSERT_EQ(float(height(tile, x, y)), float(hills(x, y)));
        ASSERT_EQ(state(tile, x, y), CellState::kMeasured);
      }
}

// A slope of a quarter over a hole of 40 cells: the lowest surface is preferred, so it may sink, but by no more than a
// few cells' rise.
TEST(HoleFilling, FollowsASlope) {
  const auto square = [](int x, int y) { return x >= 90 && x < 130 && y >= 90 && y < 130; };
  const auto slope = [](int x, int) { return 0.25 * kCell * x; };
  const SurfaceTile tile = filled(with_hole(slope, square), 100);
  for (int y = 90; y < 130; ++y)
    for (int x = 90; x < 130; ++x) ASSERT_NEAR(height(tile, x, y), slope(x, y), 0.15) << x << ' ' << y;
}

TEST(HoleFilling, BesideAWallTheGroundGoesOn) {
  const auto hole = [](int x, int y) { return x >= 100 && x < 120 && y >= 60 && y < 200; };
  const Height wall = with_hole([](int x, int) { return x >= 120 ? 4.0 : 0.0; }, hole);
  const SurfaceTile tile = filled(wall, 100);
  for (int y = 60; y < 200; ++y) {
    for (int x = 100; x < 120; ++x) {
      ASSERT_EQ(state(tile, x, y), CellState::kInterpolated);
      ASSERT_NEAR(height(tile, x, y), 0, 0.05) << x << ' ' << y;
    }
  }
}

// Half as wide as the wall is high, wherever it lies on the cells of the pyramid. A hole as wide as the wall is high is
// a slope of 45 degrees to coarse cells that hold some of both, and so a ramp in places.
TEST(HoleFilling, BesideAHighWallAWideHoleIsNoRamp) {
  for (const int width : {20, 40}) {
    for (int from = 64; from < 128; from += 5) {
      const auto hole = [=](int x, int y) { return x >= from && x < from + width && y >= 60 && y < 200; };
      const auto wall = [=](int x, int) { return x >= from + width ? 2 * width * kCell : 0.0; };
      const SurfaceTile tile = filled(with_hole(wall, hole), 100);
      for (int y = 60; y < 200; ++y) {
        for (int x = from; x < from + width; ++x) {
          ASSERT_EQ(state(tile, x, y), CellState::kInterpolated) << from << ": " << x << ' ' << y;
          ASSERT_NEAR(height(tile, x, y), 0, 0.05) << from << ": " << x << ' ' << y;
        }
      }
    }
  }
}

// What is left of it: no more than in half of the cells.
TEST(HoleFilling, BesideAWallAsHighAsTheHoleIsWideRampsAreTheSmallerPart) {
  constexpr int kWidth = 20;
  int ramps = 0;
  for (int from = 64; from < 128; from += 2) {
    const auto hole = [=](int x, int y) { return x >= from && x < from + kWidth && y >= 60 && y < 200; };
    const auto wall = [=](int x, int) { return x >= from + kWidth ? kWidth * kCell : 0.0; };
    const SurfaceTile tile = filled(with_hole(wall, hole), 100);
    ramps += height(tile, from + kWidth / 2, 130) > 0.1 * kWidth * kCell;
  }
  EXPECT_GT(ramps, 0);  // none any more: tell so
  EXPECT_LE(ramps, 16);
}

TEST(HoleFilling, AHoleInTheMiddleOfARoofStaysOnTheRoof) {
  const auto hole = [](int x, int y) { return x >= 100 && x < 116 && y >= 100 && y < 112; };
  const auto roof = [](int x, int y) { return x >= 60 && x < 160 && y >= 60 && y < 160 ? 4.0 : 0.0; };
  const SurfaceTile tile = filled(with_hole(roof, hole), 100);
  for (int y = 100; y < 112; ++y)
    for (int x = 100; x < 116; ++x) ASSERT_NEAR(height(tile, x, y), 4, 1e-5);
}

TEST(HoleFilling, SigmaGrowsIntoTheHole) {
  const auto disc = [](int x, int y) { return std::hypot(x - 110, y - 110) < 40; };
  const SurfaceTile tile = filled(with_hole([](int, int) { return 2.0; }, disc), 100);
  const auto sigma = [&](int x) { return tile.sigma_m.at(x - kFirst, 110 - kFirst); };
  EXPECT_LT(kSigma, sigma(148));
  EXPECT_LT(1.5 * sigma(148), sigma(140));
  EXPECT_LT(1.5 * sigma(140), sigma(112));
}

TEST(HoleFilling, TheOutlineOfTheBlockDoesNotBulge) {
  const Height flat = [](int x, int y) { return std::hypot(x - 110, y - 110) < 120 ? 1.0 : std::nan(""); };
  EXPECT_EQ(cells(filled(flat, 250), CellState::kInterpolated), 0u);
}

TEST(HoleFilling, ABayOfTheOutlineIsNoHole) {
  const auto bay = [](int x, int y) { return x > 60 && x < 160 && y > 180; };
  const SurfaceTile tile = filled(with_hole([](int, int) { return 1.0; }, bay), 250);
  EXPECT_EQ(state(tile, 110, 250), CellState::kEmpty);
}

// Isolated components of 12 x 12 cells in a wide hole: gaps between them up to 60 cells must not be bridged by lines.
TEST(HoleFilling, IsolatedComponentsInAwideHoleMakeNoStars) {
  const auto hole = [](int x, int y) {
    if (x < -20 || y < -20 || x >= 250 || y >= 250) return false;
    const bool isolated_component = x >= 100 && x < 112 && y >= 100 && y < 112;
    return !isolated_component;
  };
  const SurfaceTile tile = filled(with_hole([](int, int) { return 1.0; }, hole), 130);
  EXPECT_LT(cells(tile, CellState::kInterpolated), 1000u);  // of 73,000
}

// A bay of the outline is shut in along one line or two; each isolated component in it shuts in something along two
// lines more.
TEST(HoleFilling, IsolatedComponentsInAbayThrowNoRays) {
  const auto into_bay = [](int x, int y) { return x - 60 - std::abs(y - 110); };
  const auto bay = [&](int x, int y) {
    const bool isolated_component =
        (x >= 210 && x < 226 && y >= 96 && y < 112) || (x >= 190 && x < 206 && y >= 132 && y < 148);
    return into_bay(x, y) > 0 && !isolated_component;
  };
  const SurfaceTile tile = filled(with_hole([](int, int) { return 1.0; }, bay), 250);
  std::size_t in_bay = 0;
  for (int row = kFirst; row < kFirst + kSide; ++row)
    for (int column = kFirst; column < kFirst + kSide; ++column)
      in_bay += into_bay(column, row) > 2 * HoleFilling::kBlock && state(tile, column, row) == CellState::kInterpolated;
  EXPECT_EQ(in_bay, 0u);
}

TEST(HoleFilling, NarrowGapsAreClosedEverywhere) {
  const auto gap = [](int x, int y) { return x >= 100 && x < 110 && y > 40; };  // open to the outside
  const SurfaceTile tile = filled(with_hole([](int, int) { return 1.0; }, gap), 50);
  EXPECT_EQ(state(tile, 105, 100), CellState::kInterpolated);
}

TEST(HoleFilling, NothingIsFilledWhenNotWanted) {
  const auto gap = [](int x, int y) { return x >= 100 && x < 104 && y > 40 && y < 100; };
  EXPECT_EQ(cells(filled(with_hole([](int, int) { return 1.0; }, gap), 0), CellState::kInterpolated), 0u);
}

Height rough_block() {
  return [](int x, int y) {
    if (!in_block(x, y) || std::hypot(x - 60, y - 90) < 31) return std::nan("");
    Random random(std::uint64_t((x + 1000) * 4096 + y + 1000));
    if (random.uniform() < 0.35) return std::nan("");
    return std::sin(0.05 * x) + (x > 120 ? 3.0 : 0.0) + 0.1 * random.normal();
  };
}

TEST(HoleFilling, TheCutIntoTilesAndWindowsDoesNotMatter) {
  const Height rough = rough_block();
  const SurfaceTile whole = filled(rough, 100);
  EXPECT_GT(cells(whole, CellState::kInterpolated), 20'000u);
  const HoleFilling holes = prepared(rough, 100, 128);
  for (int y = 0; y < kSide; y += 150) {
    for (int x = 0; x < kSide; x += 75) {
      const SurfaceTile part = window_of(holes, rough, {kFirst + x, kFirst + y, 75, 150});
      const SurfaceTile expected = cropped(whole, {x, y, 75, 150});
      ASSERT_EQ(part.height_m.data, expected.height_m.data);
      ASSERT_EQ(part.sigma_m.data, expected.sigma_m.data);
      ASSERT_EQ(part.state.data, expected.state.data);
    }
  }
}

TEST(MeasuredTiles, WhatWentToFilesComesBack) {
  const auto scratch = std::filesystem::temp_directory_path() / "collinea_measured_tiles_test";
  const auto ramp = [](int column, int row) { return (column + row) % 7 == 0 ? std::nan("") : column + 0.001 * row; };
  constexpr int kCells = MeasuredTiles::kCells;
  {
    MeasuredTiles tiles(scratch, std::size_t{7} << 20);  // two squares and a half
    for (int row = -1; row < 1; ++row)
      for (int column = -1; column < 1; ++column)
        ASSERT_TRUE(tiles.add({column, row}, measured({column * kCells, row * kCells, kCells, kCells}, ramp)));
    EXPECT_FALSE(std::filesystem::is_empty(scratch));
    const CellWindow window{-30, -40, 70, 90};
    const auto found = tiles.window(window);
    ASSERT_TRUE(found);
    const SurfaceTile expected = measured(window, ramp);
    EXPECT_EQ(found->height_m.data, expected.height_m.data);
    EXPECT_EQ(found->sigma_m.data, expected.sigma_m.data);
    EXPECT_EQ(found->state.data, expected.state.data);
    EXPECT_EQ(found->count.data, expected.count.data);
  }
  EXPECT_FALSE(std::filesystem::exists(scratch));
}

TEST(MeasuredTiles, AFolderThatCannotBeMadeIsNamed) {
  const TestFolder folder;
  std::ofstream(folder / "file") << "no folder";
  MeasuredTiles tiles(folder / "file" / "scratch", 0);
  const auto added = tiles.add({0, 0}, SurfaceTile(MeasuredTiles::kCells, MeasuredTiles::kCells));
  ASSERT_FALSE(added);
  EXPECT_NE(added.error().message.find("cannot make " + (folder / "file").string()), std::string::npos)
      << added.error().message;
}

}  // namespace
}  // namespace collinea
