// SPDX-License-Identifier: Apache-2.0
#include "collinea/surface/dsm.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>

#include "collinea/base/test_folder.h"
#include "collinea/math/random.h"
#include "collinea/surface/internal/point_buckets.h"

namespace collinea {
namespace {

// A model collected in memory.
struct Collected {
  MapGrid grid;
  FloatImage height_m, sigma_m, sigma_relative_m;
  Result<DsmSummary> summary;
};

double hill_m(double x, double y) { return 0.1 * x + 0.5 * std::sin(0.1 * y); }

std::vector<SurfacePoint> hill(double west, double south, double size, int count) {
  Random random(4);
  std::vector<SurfacePoint> points;
  for (int i = 0; i < count; ++i) {
    const double x = west + random.uniform(0, size), y = south + random.uniform(0, size);
    points.push_back({{x, y, hill_m(x, y)}, 0.02f});
  }
  return points;
}

Collected build(std::vector<SurfacePoint> points, const DsmOptions& options, int threads = 1,
                const LocalFrame* frame = nullptr, PointFrame point_frame = PointFrame::kWorld,
                const std::vector<PositionSigma>& position_sigmas = {}) {
  std::size_t next = 0;
  const PointSource source = [&](std::vector<SurfacePoint>& batch) -> Result<> {
    const std::size_t end = std::min(next + 1000, points.size());
    batch.assign(points.begin() + std::ptrdiff_t(next), points.begin() + std::ptrdiff_t(end));
    next = end;
    return {};
  };
  Collected result;
  const SurfaceSink sink{
      [&](const MapGrid& grid) -> Result<> {
        result.grid = grid;
        result.height_m = result.sigma_m = result.sigma_relative_m = FloatImage(grid.width, grid.height, 1, -1);
        return {};
      },
      [&](int column, int row, const SurfaceTile& tile) -> Result<> {
        for (int y = 0; y < tile.height_m.height; ++y) {
          std::copy_n(tile.height_m.row(y), tile.height_m.width, result.height_m.row(row + y) + column);
          std::copy_n(tile.sigma_m.row(y), tile.sigma_m.width, result.sigma_m.row(row + y) + column);
          std::copy_n(tile.sigma_relative_m.row(y), tile.sigma_m.width, result.sigma_relative_m.row(row + y) + column);
        }
        return {};
      }};
  Run run;
  run.threads = threads;
  result.summary = build_dsm({source, frame, point_frame, 0.1234, position_sigmas}, sink, "unused", options, run);
  return result;
}

// The curvature of the hill over 1.5 cells is below 1 mm.
TEST(Dsm, HeightsLieWhereTheMapSays) {
  const Collected dsm = build(hill(-3, 7, 12, 50'000), {});
  ASSERT_TRUE(dsm.summary);
  EXPECT_EQ(dsm.grid.cell_m, 0.12);
  EXPECT_NEAR(dsm.grid.west_m, -3, 0.12);
  EXPECT_NEAR(dsm.grid.north_m, 19, 0.12);
  EXPECT_NEAR(dsm.grid.west_m / 0.12, std::round(dsm.grid.west_m / 0.12), 1e-9);
  for (int row = 1; row < dsm.grid.height - 1; ++row)
    for (int column = 1; column < dsm.grid.width - 1; ++column)
      ASSERT_NEAR(dsm.height_m.at(column, row), hill_m(dsm.grid.east_of(column + 0.5), dsm.grid.north_of(row + 0.5)),
                  2e-3);
  EXPECT_GT(dsm.summary->measured_cells, 9900u);
  EXPECT_EQ(dsm.summary->points, 50'000u);
}

// A wide lawn with a courtyard's ground and a roof beside it, both apart from it, and a mirror image far below.
TEST(Dsm, IsolatedComponentsFarBelowEverythingGo) {
  Random random(6);
  std::vector<SurfacePoint> points;
  const auto patch = [&](double west, double south, double size, double height_m) {
    for (int i = 0; i < int(size * size * 200); ++i)
      points.push_back({{west + random.uniform(0, size), south + random.uniform(0, size), height_m}, 0.02f});
  };
  patch(0, 0, 60, 2);
  patch(64, 10, 5, 8);    // a roof without walls
  patch(64, 30, 5, 1.5);  // ground across a gap
  patch(64, 50, 5, -20);
  const Collected dsm = build(points, {.cell_m = 0.1, .fill_holes_m = 0});
  ASSERT_TRUE(dsm.summary);
  const auto at = [&](double x, double y) {
    return dsm.height_m.at(int((x - dsm.grid.west_m) / 0.1), int((dsm.grid.north_m - y) / 0.1));
  };
  EXPECT_NEAR(at(30, 30), 2, 1e-3);
  EXPECT_NEAR(at(66, 12), 8, 1e-3);
  EXPECT_NEAR(at(66, 32), 1.5, 1e-3);
  EXPECT_EQ(at(66, 52), kNoHeight);
  EXPECT_EQ(dsm.summary->points_dropped, 5000u);
}

// A lawn that three images tell, and what two alone tell, apart from it and beside it.
TEST(Dsm, IsolatedComponentsOfTwoImagesGo) {
  const auto heights = [](std::uint8_t of_lawn, std::uint8_t of_isolated_component) {
    Random random(6);
    std::vector<SurfacePoint> points;
    const auto patch = [&](double west, double south, double size, double height_m, std::uint8_t images) {
      for (int i = 0; i < int(size * size * 200); ++i)
        points.push_back({{west + random.uniform(0, size), south + random.uniform(0, size), height_m}, 0.02f, images});
    };
    patch(0, 0, 60, 2, of_lawn);
    patch(60, 10, 5, 2.5, 2);
    patch(65, 50, 5, 3, of_isolated_component);
    const Collected dsm = build(points, {.cell_m = 0.1, .fill_holes_m = 0});
    const auto at = [&](double x, double y) {
      const int column = int((x - dsm.grid.west_m) / 0.1), row = int((dsm.grid.north_m - y) / 0.1);
      return column < dsm.grid.width ? dsm.height_m.at(column, row) : kNoHeight;
    };
    return std::array{at(30, 30), at(62, 12), at(67, 52)};
  };
  EXPECT_EQ(heights(3, 2), (std::array{2.0f, 2.5f, kNoHeight}));
  EXPECT_EQ(heights(3, 3), (std::array{2.0f, 2.5f, 3.0f}));
  EXPECT_EQ(heights(3, 0), (std::array{2.0f, 2.5f, 3.0f}));  // not known by how many
  EXPECT_EQ(heights(2, 2), (std::array{2.0f, 2.5f, 3.0f}));  // a block of two images
}

// An isolated component beyond everything, and a stray that would be one if it were not part of it.
TEST(Dsm, WhatGoesIsCountedOnceAndNotPartOfTheRaster) {
  Random random(6);
  std::vector<SurfacePoint> points;
  const auto patch = [&](double west, double south, double size, double height_m) {
    for (int i = 0; i < int(size * size * 200); ++i)
      points.push_back({{west + random.uniform(0, size), south + random.uniform(0, size), height_m}, 0.02f});
  };
  patch(0, 0, 60, 2);
  patch(64, 50, 5, -20);
  patch(200, 50, 2, -200);
  const Collected dsm = build(points, {.cell_m = 0.1});
  ASSERT_TRUE(dsm.summary);
  EXPECT_EQ(dsm.summary->points_dropped, 5000u + 800u);
  EXPECT_EQ(dsm.grid.width, 600);
  EXPECT_EQ(dsm.grid.height, 600);
}

// At a position with a sigma of its own that is what is added; far from all it is that of the nearest ones; nothing is
// added where there is no height.
TEST(Dsm, SigmasKnowWhatTheOrientationLeavesOpen) {
  std::vector<SurfacePoint> points = hill(0, 0, 40, 100'000);
  std::erase_if(points, [](const SurfacePoint& p) { return std::hypot(p.position.x() - 30, p.position.y() - 10) < 5; });
  const std::vector<PositionSigma> position_sigmas = {{8, 20, 0.05}, {32, 20, 0.15}};
  const DsmOptions options{.cell_m = 0.25, .fill_holes_m = 0};
  const Collected bare = build(points, options);
  const Collected dsm = build(points, options, 2, nullptr, PointFrame::kWorld, position_sigmas);
  ASSERT_TRUE(bare.summary && dsm.summary);
  const auto added = [&](double x, double y) {
    const int column = int((x - dsm.grid.west_m) / 0.25), row = int((dsm.grid.north_m - y) / 0.25);
    const double own = double(bare.sigma_m.at(column, row)), all = double(dsm.sigma_m.at(column, row));
    return own == double(kNoHeight) ? all : std::sqrt(all * all - own * own);
  };
  EXPECT_NEAR(added(8, 20), 0.05, 0.005);  // a step of the lattice is 3.4 cells
  EXPECT_NEAR(added(32, 20), 0.15, 0.005);
  EXPECT_NEAR(added(20, 20), std::sqrt((0.05 * 0.05 + 0.15 * 0.15) / 2), 0.005);
  EXPECT_EQ(added(30, 10), double(kNoHeight));
  EXPECT_GT(dsm.summary->mean_sigma_m, 0.09);
  EXPECT_EQ(bare.height_m.data, dsm.height_m.data);
  EXPECT_EQ(bare.sigma_m.data, dsm.sigma_relative_m.data);
  EXPECT_EQ(bare.summary->mean_sigma_m, dsm.summary->mean_sigma_relative_m);
}

// Positions on the map differ by the 1e-9 m to which PROJ's way there and back is exact, heights by that times the
// slope.
TEST(Dsm, PointsMayComeInTheWorldOrOnTheMap) {
  const auto frame = LocalFrame::create("EPSG:32633", 48.2, 15.63, 300);
  ASSERT_TRUE(frame) << frame.error().message;
  auto points = hill(546'800, 5'338'700, 10, 30'000);
  const Collected by_map = build(points, {}, 1, &*frame, PointFrame::kMap);
  for (SurfacePoint& p : points) p.position = frame->local_from_map(p.position);
  const Collected by_world = build(points, {}, 1, &*frame);
  ASSERT_TRUE(by_map.summary && by_world.summary);
  EXPECT_FALSE(by_map.grid.wkt.empty());
  EXPECT_NEAR(by_map.grid.west_m, 546'800, 0.12);
  ASSERT_EQ(by_map.height_m.data.size(), by_world.height_m.data.size());
  std::size_t different = 0;
  for (std::size_t i = 0; i < by_map.height_m.data.size(); ++i)
    different += std::abs(by_map.height_m.data[i] - by_world.height_m.data[i]) > 1e-2f;
  EXPECT_LE(different, 3u);  // points within 1e-9 m of the edge of a cell
}

TEST(Dsm, ThreadsAndOrderDoNotMatter) {
  auto points = hill(0, 0, 75, 60'000);
  const Collected one = build(points, {});
  std::reverse(points.begin(), points.end());
  const Collected other = build(points, {}, 3);
  ASSERT_TRUE(one.summary && other.summary);
  EXPECT_GT(one.grid.width, 512);  // more than one tile
  EXPECT_EQ(one.height_m.data, other.height_m.data);
  EXPECT_EQ(one.summary->mean_sigma_m, other.summary->mean_sigma_m);
}

TEST(Dsm, AStrayPointFarAwayDoesNotStretchTheRaster) {
  auto points = hill(0, 0, 10, 20'000);
  points.push_back({{1e5, -3e4, 0}, 0.02f});
  points.push_back({{std::nan(""), 0, 0}, 0.02f});
  const Collected dsm = build(points, {});
  ASSERT_TRUE(dsm.summary);
  EXPECT_LT(dsm.grid.width, 100);
  EXPECT_EQ(dsm.summary->points_dropped, 2u);
}

TEST(Dsm, NoPointsIsAnError) {
  const Collected dsm = build({}, {});
  ASSERT_FALSE(dsm.summary);
  EXPECT_EQ(dsm.summary.error().code, Errc::kIllPosed);
}

TEST(Dsm, CellsAreTidyNumbers) {
  EXPECT_EQ(tidy_cell_m(0.02371), 0.024);
  EXPECT_EQ(tidy_cell_m(0.0996), 0.1);
  EXPECT_EQ(tidy_cell_m(12.4), 12);
}

TEST(PointBuckets, WhatWentToFilesComesBack) {
  const auto scratch = std::filesystem::temp_directory_path() / "collinea_point_buckets_test";
  Random random(8);
  std::vector<GridPoint> points;
  for (int i = 0; i < 5000; ++i)
    points.push_back({random.uniform(-100, 100), random.uniform(-100, 100), double(i), 0.1f, 0});
  {
    PointBuckets buckets(scratch, 32, 1000 * sizeof(GridPoint));
    for (std::size_t i = 0; i < points.size(); i += 700)
      ASSERT_TRUE(buckets.add(std::span(points).subspan(i, std::min<std::size_t>(700, points.size() - i))));
    EXPECT_FALSE(std::filesystem::is_empty(scratch));
    auto found = buckets.points_in({-40, -10, 75, 33});
    ASSERT_TRUE(found);
    std::vector<double> heights, expected;
    for (const GridPoint& p : *found) heights.push_back(p.height_m);
    for (const GridPoint& p : points)
      if (p.column >= -40 && p.column < 35 && p.row >= -10 && p.row < 23) expected.push_back(p.height_m);
    std::sort(heights.begin(), heights.end());
    EXPECT_EQ(heights, expected);
  }
  EXPECT_FALSE(std::filesystem::exists(scratch));
}

// A disk that is full (a link to what behaves like one), and a folder that cannot be made.
TEST(PointBuckets, WhatCannotBeWrittenIsStatedAndLeavesNothing) {
  const TestFolder folder;
  const std::vector<GridPoint> points(100, {1, 1, 5, 0.1f, 0});
  std::filesystem::create_directory(folder / "full");
  std::filesystem::create_symlink("/dev/full", folder / "full" / "points_0_0.bin");
  {
    PointBuckets buckets(folder / "full", 32, sizeof(GridPoint));
    const auto added = buckets.add(points);
    ASSERT_FALSE(added);
    EXPECT_NE(added.error().message.find("No space left"), std::string::npos) << added.error().message;
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder / "full"));
  std::ofstream(folder / "file") << "no folder";
  PointBuckets buckets(folder / "file" / "scratch", 32, sizeof(GridPoint));
  const auto added = buckets.add(points);
  ASSERT_FALSE(added);
  EXPECT_NE(added.error().message.find("cannot make " + (folder / "file").string()), std::string::npos)
      << added.error().message;
}

TEST(PointBuckets, HoldNoMoreOfManyPointsThanOfFew) {
  constexpr std::size_t kLimit = 1000 * sizeof(GridPoint);
  PointBuckets buckets(std::filesystem::temp_directory_path() / "collinea_point_buckets_memory_test", 32, kLimit);
  Random random(8);
  std::vector<GridPoint> points(100);
  std::size_t most = 0;
  for (int i = 0; i < 200; ++i) {
    for (GridPoint& point : points) point = {random.uniform(-100, 100), random.uniform(-100, 100), double(i), 0.1f, 0};
    ASSERT_TRUE(buckets.add(points));
    std::size_t room = 0;
    for (const auto& [square, bucket] : buckets.buckets()) room += bucket.in_memory.capacity();
    ASSERT_EQ(buckets.bytes_in_memory(), room * sizeof(GridPoint));
    most = std::max(most, buckets.bytes_in_memory());
  }
  ASSERT_TRUE(buckets.finish());
  EXPECT_EQ(buckets.bytes_in_memory(), 0u);
  EXPECT_LE(most, kLimit);
  EXPECT_GT(most, kLimit / 2);
}

}  // namespace
}  // namespace collinea
