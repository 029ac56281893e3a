// SPDX-License-Identifier: Apache-2.0
#include "collinea/surface/internal/gridding.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <numbers>
#include <vector>

#include "collinea/math/random.h"
#include "collinea/surface/internal/cell_fit.h"

namespace collinea {
namespace {

constexpr float kSigma = 0.02f;

// Points at random positions over [from, to)^2 cells, on a surface over (column, row).
std::vector<GridPoint> sprinkle(double from, double to, double per_cell,
                                const std::function<double(double, double)>& height_m, double noise_m = 0) {
  Random random(3);
  std::vector<GridPoint> points;
  const auto count = std::size_t(per_cell * (to - from) * (to - from));
  for (std::size_t i = 0; i < count; ++i) {
    const double column = random.uniform(from, to), row = random.uniform(from, to);
    points.push_back({column, row, height_m(column, row) + noise_m * random.normal(), kSigma, 0});
  }
  return points;
}

// Four points in each cell, one in each quarter at a random position.
std::vector<GridPoint> spread(const std::function<double(double, double)>& height_m) {
  Random random(6);
  std::vector<GridPoint> points;
  for (int i = -40; i < 120; ++i) {
    for (int j = -40; j < 120; ++j) {
      const double column = (j + random.uniform()) / 2, row = (i + random.uniform()) / 2;
      points.push_back({column, row, height_m(column, row), kSigma, 0});
    }
  }
  return points;
}

PointsOf those_of(const std::vector<GridPoint>& points) {
  return [&points](const CellWindow& window) -> Result<std::vector<GridPoint>> {
    std::vector<GridPoint> found;
    std::copy_if(points.begin(), points.end(), std::back_inserter(found), [&](const GridPoint& p) {
      return p.column >= double(window.column) && p.column < double(window.column + window.width) &&
             p.row >= double(window.row) && p.row < double(window.row + window.height);
    });
    return found;
  };
}

SurfaceTile measure_window(const std::vector<GridPoint>& points, const CellWindow& window, const Gridding& gridding) {
  return measure_window(those_of(points), window, gridding).value();
}

bool is(const SurfaceTile& tile, CellState state, int x, int y) { return tile.state.at(x, y) == std::uint8_t(state); }

double share(const SurfaceTile& tile, CellState state) {
  return double(std::count(tile.state.data.begin(), tile.state.data.end(), std::uint8_t(state))) /
         double(tile.state.data.size());
}

const CellWindow kWindow{0, 0, 40, 40};
constexpr double kCell = 0.1;

// Only float storage of heights near 3 m (half a unit in the last place: 1.2e-7 m) and the rounding of the fit are
// left.
TEST(Gridding, MeetsAnInclinedPlane) {
  const auto plane = [](double x, double y) { return 1.0 + 0.03 * x - 0.02 * y; };
  const SurfaceTile tile = measure_window(spread(plane), kWindow, {kCell});
  EXPECT_EQ(share(tile, CellState::kMeasured), 1);
  double worst = 0;
  for (int y = 0; y < 40; ++y)
    for (int x = 0; x < 40; ++x) worst = std::max(worst, std::abs(tile.height_m.at(x, y) - plane(x + 0.5, y + 0.5)));
  EXPECT_LT(worst, 1e-6);
}

// Weighting must take the upper tail for noise, not for a level: the mean error over 1600 cells stays within four of
// its sigmas (about 0.02 m / sqrt(cells), neighbours share points: taken as 400 independent cells).
TEST(Gridding, NoiseDoesNotLiftFlatGround) {
  const SurfaceTile tile = measure_window(sprinkle(
                                              -20, 60, 4, [](double, double) { return 5; }, kSigma),
                                          kWindow, {kCell});
  double sum = 0, squares = 0, claimed = 0;
  for (std::size_t i = 0; i < tile.height_m.data.size(); ++i) {
    const double error = tile.height_m.data[i] - 5.0;
    sum += error, squares += error * error, claimed += std::pow(tile.sigma_m.data[i], 2);
  }
  EXPECT_NEAR(sum / 1600, 0, 4 * kSigma / std::sqrt(400));
  EXPECT_LT(squares / 1600, claimed / 1600 * 1.3);
  EXPECT_GT(squares / 1600, claimed / 1600 * 0.4);
}

// White noise under a Gaussian of the width w is alike by exp(-d^2 / 4 w^2). What all points of a cell share, no number
// of them makes smaller.
TEST(Gridding, SigmaCoversErrorsThatAreAlike) {
  constexpr double kAlike = 3.1, kWidth = 2 * kAlike / std::numbers::sqrt2;  // of cells, of half cells
  constexpr int kBlocks = 60, kSide = 64, kReach = 12;                       // half cells
  double chi2 = 0;
  int cells = 0;
  for (int block = 0; block < kBlocks; ++block) {
    Random random(8, std::uint64_t(block));
    constexpr int kAll = kSide + 2 * kReach;
    std::vector<double> white(kAll * kAll), rows(white.size());
    for (double& value : white) value = random.normal();
    double weight[2 * kReach + 1], squares = 0;
    for (int i = -kReach; i <= kReach; ++i)
      squares += std::pow(weight[i + kReach] = std::exp(-0.5 * i * i / (kWidth * kWidth)), 2);
    for (int y = 0; y < kAll; ++y)
      for (int x = kReach; x < kSide + kReach; ++x)
        for (int i = -kReach; i <= kReach; ++i)
          rows[std::size_t(y * kAll + x)] += weight[i + kReach] * white[std::size_t(y * kAll + x + i)];
    std::vector<GridPoint> points;
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x) {
        double sum = 0;
        for (int i = -kReach; i <= kReach; ++i)
          sum += weight[i + kReach] * rows[std::size_t((y + kReach + i) * kAll + x + kReach)];
        const double error = std::sqrt(0.93) * sum / squares + std::sqrt(0.07) * random.normal();
        points.push_back({x / 2.0 + 0.25, y / 2.0 + 0.25, 5 + kSigma * error, kSigma, 0});
      }
    const SurfaceTile tile = measure_window(std::move(points), {0, 0, kSide / 2, kSide / 2}, {kCell, kAlike});
    for (int y = 4; y < kSide / 2; y += 12)
      for (int x = 4; x < kSide / 2; x += 12, ++cells)
        chi2 += std::pow((tile.height_m.at(x, y) - 5) / tile.sigma_m.at(x, y), 2);
  }
  EXPECT_NEAR(chi2 / cells, 1, 4 * std::sqrt(2.0 / cells));
  EXPECT_NEAR(share_alike(kAlike), 0.88, 0.01);
  EXPECT_EQ(share_alike(0), 0);
}

// However few points there are: what they do not share is a share of their variance, divided by their number.
TEST(CellFit, SigmaCoversErrorsThatAreAlikeOfAFewPoints) {
  constexpr double kAlike = 3.1;  // cells
  constexpr int kCells = 8000;
  for (const int count : {2, 3, 4}) {
    Random random(7, std::uint64_t(count));
    CellFit fit(share_alike(kAlike));
    double chi2 = 0;
    for (int cell = 0; cell < kCells; ++cell) {
      std::vector<CellPoint> points;
      Eigen::MatrixXd covariance(count, count);
      Eigen::VectorXd white(count);
      for (int i = 0; i < count; ++i) {  // within 1.2 cells
        const double distance = 1.2 * std::sqrt(random.uniform()), to = random.uniform(0, 2 * std::numbers::pi);
        points.push_back({distance * std::cos(to), distance * std::sin(to), 5, kSigma, true});
        white[i] = random.normal();
        for (int j = 0; j <= i; ++j) {
          const double d2 = std::pow(points[std::size_t(i)].x - points[std::size_t(j)].x, 2) +
                            std::pow(points[std::size_t(i)].y - points[std::size_t(j)].y, 2);
          covariance(i, j) = covariance(j, i) = 0.93 * std::exp(-d2 / (2 * kAlike * kAlike)) + (i == j ? 0.07 : 0);
        }
      }
      const Eigen::VectorXd errors = covariance.llt().matrixL() * white;
      for (int i = 0; i < count; ++i) points[std::size_t(i)].height_m += kSigma * errors[i];
      const auto estimate = fit.estimate(points, kCell);
      ASSERT_TRUE(estimate);
      chi2 += std::pow((estimate->height_m - 5) / estimate->sigma_m, 2);
    }
    EXPECT_NEAR(chi2 / kCells, 1, 4 * std::sqrt(2.0 / kCells)) << count;
  }
}

// On a slope a pixel's breadth of doubt where a point lies is doubt of the height, however many points there are.
TEST(Gridding, SigmaOnASlopeKnowsThatPositionsAreKnownToAPixel) {
  const double slope = 0.9;
  const auto plane = [&](double x, double y) { return slope * kCell * (0.6 * x + 0.8 * y); };
  const SurfaceTile level = measure_window(spread([](double, double) { return 0; }), kWindow, {kCell});
  const SurfaceTile tilted = measure_window(spread(plane), kWindow, {kCell});
  for (std::size_t i = 0; i < level.sigma_m.data.size(); ++i) {
    const double own = double(level.sigma_m.data[i]), all = double(tilted.sigma_m.data[i]);
    ASSERT_NEAR(all * all - own * own, std::pow(slope * kCell, 2) / 12, 2e-5) << i;
  }
}

TEST(Gridding, AStepKeepsBothLevels) {
  const auto step = [](double x, double) { return x < 20 ? 0.0 : 3.0; };
  const SurfaceTile tile = measure_window(spread(step), kWindow, {kCell});
  for (int y = 0; y < 40; ++y)
    for (int x = 0; x < 40; ++x) ASSERT_NEAR(tile.height_m.at(x, y), x < 20 ? 0.0 : 3.0, 1e-6) << x << ' ' << y;
}

TEST(Gridding, PointsOnAWallGiveTheRoof) {
  auto points = sprinkle(-20, 60, 3, [](double x, double) { return x < 20 ? 0.0 : 3.0; });
  Random random(9);
  for (int i = 0; i < 80 * 40; ++i) points.push_back({20.3, random.uniform(-20, 60), random.uniform(0, 3), kSigma, 0});
  const SurfaceTile tile = measure_window(std::move(points), kWindow, {kCell});
  for (int y = 0; y < 40; ++y) {
    EXPECT_NEAR(tile.height_m.at(20, y), 3, 0.1) << y;  // one cell: the rim of the roof may bend a little
    EXPECT_NEAR(tile.height_m.at(18, y), 0, 0.02) << y;
    EXPECT_NEAR(tile.height_m.at(22, y), 3, 0.02) << y;
  }
}

TEST(Gridding, SinglePointsAboveAndBelowAreIgnored) {
  auto points = sprinkle(-20, 60, 3, [](double, double) { return 0; });
  for (int i = 2; i < 40; i += 6) points.push_back({i + 0.5, i + 0.4, i % 4 ? 2.0 : -2.0, kSigma, 0});
  const SurfaceTile tile = measure_window(std::move(points), kWindow, {kCell});
  for (const float z : tile.height_m.data) ASSERT_NEAR(z, 0, 1e-6);
}

TEST(Gridding, ASmallClumpOfWrongPointsIsRemoved) {
  auto points = sprinkle(-20, 60, 3, [](double, double) { return 0; });
  Random random(5);
  for (int i = 0; i < 12; ++i) points.push_back({10 + random.uniform(0, 2), 10 + random.uniform(0, 2), 4.0, kSigma, 0});
  const SurfaceTile tile = measure_window(std::move(points), kWindow, {kCell});
  for (std::size_t i = 0; i < tile.state.data.size(); ++i) {
    const bool measured = tile.state.data[i] == std::uint8_t(CellState::kMeasured);
    ASSERT_NEAR(measured ? tile.height_m.data[i] : 0, 0, 1e-6);
  }
  EXPECT_TRUE(is(tile, CellState::kEmpty, 10, 10));
}

TEST(Gridding, AChimneyOfFourCellsStays) {
  const auto chimney = [](double x, double y) { return x >= 18 && x < 22 && y >= 18 && y < 22 ? 2.0 : 0.0; };
  const SurfaceTile tile = measure_window(sprinkle(-20, 60, 3, chimney), kWindow, {kCell});
  EXPECT_NEAR(tile.height_m.at(19, 19), 2, 1e-6);
  EXPECT_NEAR(tile.height_m.at(20, 20), 2, 1e-6);
  EXPECT_NEAR(tile.height_m.at(15, 20), 0, 1e-6);
}

TEST(Gridding, ASparseCloudStillGivesASurface) {
  const SurfaceTile tile = measure_window(sprinkle(-20, 60, 0.6, [](double, double) { return 1; }), kWindow, {kCell});
  EXPECT_GT(share(tile, CellState::kMeasured), 0.85);
}

std::vector<GridPoint> with_hole(double from, double to) {
  auto points = spread([](double x, double) { return 0.02 * x; });
  std::erase_if(points,
                [&](const GridPoint& p) { return p.column >= from && p.column < to && p.row >= from && p.row < to; });
  return points;
}

TEST(Gridding, HolesHaveNoHeight) {
  const SurfaceTile tile = measure_window(with_hole(15, 25), kWindow, {kCell});
  EXPECT_TRUE(is(tile, CellState::kEmpty, 20, 20));
  EXPECT_EQ(tile.height_m.at(20, 20), kNoHeight);
  EXPECT_EQ(tile.count.at(20, 20), 0);
  EXPECT_TRUE(is(tile, CellState::kMeasured, 13, 20));
}

TEST(Gridding, NeitherTheOrderOfPointsNorTheCutIntoWindowsMatters) {
  const auto hills = [](double x, double y) { return std::sin(0.3 * x) + (y > 17 ? 2 : 0); };
  auto points = sprinkle(-30, 70, 1.2, hills, 0.05);
  const SurfaceTile whole = measure_window(points, kWindow, {kCell});
  std::reverse(points.begin(), points.end());
  for (int y = 0; y < 40; y += 10) {
    for (int x = 0; x < 40; x += 20) {
      const SurfaceTile part = measure_window(points, {x, y, 20, 10}, {kCell});
      for (int j = 0; j < 10; ++j) {
        for (int i = 0; i < 20; ++i) {
          ASSERT_EQ(part.height_m.at(i, j), whole.height_m.at(x + i, y + j)) << x + i << ' ' << y + j;
          ASSERT_EQ(part.sigma_m.at(i, j), whole.sigma_m.at(x + i, y + j));
          ASSERT_EQ(part.state.at(i, j), whole.state.at(x + i, y + j));
          ASSERT_EQ(part.count.at(i, j), whole.count.at(x + i, y + j));
        }
      }
    }
  }
}

// Several bands and a part of one, against single rows of a band each.
TEST(Gridding, BandsAreNarrowAndLeaveNoTrace) {
  const auto points = sprinkle(
      -20, 180, 3, [](double x, double y) { return std::sin(x * y); }, 0.1);
  const CellWindow window{3, -7, 30, 160};
  int tallest = 0;
  const auto whole = measure_window(
      [&](const CellWindow& asked) {
        tallest = std::max(tallest, asked.height);
        return those_of(points)(asked);
      },
      window, {kCell});
  ASSERT_TRUE(whole);
  EXPECT_LT(tallest, window.height / 2);
  for (int y = 0; y < window.height; y += 11) {
    const SurfaceTile row = measure_window(points, {window.column, window.row + y, window.width, 1}, {kCell});
    for (int x = 0; x < window.width; ++x) {
      EXPECT_EQ(row.height_m.at(x, 0), whole->height_m.at(x, y));
      EXPECT_EQ(row.sigma_m.at(x, 0), whole->sigma_m.at(x, y));
      EXPECT_EQ(row.count.at(x, 0), whole->count.at(x, y));
    }
  }
}

TEST(Gridding, WhatPointsCannotBeReadForIsAnError) {
  const auto broken = [](const CellWindow&) -> Result<std::vector<GridPoint>> {
    return fail(Errc::kBadFormat, "disk");
  };
  EXPECT_FALSE(measure_window(broken, kWindow, {kCell}));
}

TEST(Gridding, WithoutPointsThereAreNoRasters) {
  EXPECT_TRUE(measure_window(std::vector<GridPoint>(), kWindow, {kCell}).state.empty());
}

}  // namespace
}  // namespace collinea
