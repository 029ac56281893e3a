// SPDX-License-Identifier: Apache-2.0
#include "collinea/restitution/map_height.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "collinea/block/world_frame.h"
#include "collinea/math/random.h"

namespace collinea {
namespace {

using Eigen::Vector2d;

constexpr double kCell_m = 0.5;

double plane(double east, double north) { return 100 + 0.1 * (east - 1000) - 0.2 * (north - 5000); }

/// A plane of many cells with a hole, that counts what is read.
struct Raster {
  MapGrid grid{1000, 5000, kCell_m, 3000, 2000, ""};
  std::shared_ptr<std::multiset<std::pair<int, int>>> reads = std::make_shared<std::multiset<std::pair<int, int>>>();

  [[nodiscard]] HeightField field() const {
    HeightField field{.grid = grid, .read = {}, .read_sigma = {}};
    field.read = [grid = grid, reads = reads](int column, int row, int width, int height) -> Result<FloatImage> {
      EXPECT_TRUE(column >= 0 && row >= 0 && column + width <= grid.width && row + height <= grid.height);
      EXPECT_LE(width, kHeightTile + 2);
      EXPECT_LE(height, kHeightTile + 2);
      reads->insert({column, row});
      if (column > 2800) return fail(Errc::kBadFormat, "broken");
      FloatImage out(width, height, 1);
      for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
          const double east = grid.east_of(column + x + 0.5), north = grid.north_of(row + y + 0.5);
          out.at(x, y) = std::hypot(east - 1200, north - 4800) < 20 ? std::nanf("") : float(plane(east, north));
        }
      return out;
    };
    return field;
  }
};

// A plane is bilinear, so that heights between cells are those of the plane, also across the borders of tiles; within
// half a cell of the raster's border they are those of the nearest cell.
TEST(MapHeight, IsThatOfTheRasterWhereverItIsAsked) {
  const Raster raster;
  const MapHeight height = heights_by_need(raster.field());
  Random random(3);
  for (int i = 0; i < 3000; ++i) {
    const Vector2d at(1000 + 1390 * random.uniform(), 5000 - 1000 * random.uniform());
    if (std::abs((at - Vector2d(1200, 4800)).norm() - 20) < 1) continue;
    const auto found = height(at);
    if ((at - Vector2d(1200, 4800)).norm() < 20) {
      EXPECT_FALSE(found);
      continue;
    }
    ASSERT_TRUE(found) << at.transpose();
    EXPECT_NEAR(*found, plane(at.x(), at.y()), 0.3 * kCell_m * 0.5 + 1e-4) << at.transpose();
  }
  // Exactly at the border of two tiles.
  const double border = 1000 + kHeightTile * kCell_m;
  EXPECT_NEAR(*height({border, 4900}), plane(border, 4900), 1e-4);
  EXPECT_NEAR(*height({border - 1e-6, 4900}), *height({border + 1e-6, 4900}), 1e-4);
  for (const Vector2d& beside : {Vector2d(999, 4900), Vector2d(1100, 5001), Vector2d(2501, 4900), Vector2d(1100, 3999),
                                 Vector2d(std::nan(""), 4900)})
    EXPECT_FALSE(height(beside));
  EXPECT_FALSE(height({2490, 4900}));  // what cannot be read
}

TEST(MapHeight, ReadsWhatIsNeededOnceAndKeepsABoundedPart) {
  const Raster raster;
  const MapHeight height = heights_by_need(raster.field()), copy = height;
  EXPECT_TRUE(raster.reads->empty());
  for (int i = 0; i < 500; ++i) (void)height({1100 + 0.01 * i, 4900}), (void)copy({1100, 4900 + 0.01 * i});
  EXPECT_LE(raster.reads->size(), 4u);
  const std::size_t before = raster.reads->size();
  for (int column = 0; column < 22; ++column)
    for (int row = 0; row < 15; ++row) (void)height({1010 + 64.0 * column, 4990 - 64.0 * row});
  EXPECT_GT(raster.reads->size() - before, kMostHeightTiles);
  (void)height({1100, 4900});  // it was left behind
  EXPECT_GT(raster.reads->count({127, 127}), 1u);
}

// In the world of a block the surface is as high as its place on the Earth is, 5 km from the origin 2 m lower.
TEST(MapHeight, InTheWorldItCurves) {
  const LocalFrame frame = *world_frame(Georeference{"EPSG:32633", 48.2, 15.63, 300});
  const SurfaceHeight height = surface_in_world(&frame, [](const Vector2d&) -> std::optional<double> { return 310.0; });
  EXPECT_NEAR(*height({0, 0}), 10, 1e-3);
  const Vector2d far(5000, 0);
  const Eigen::Vector3d on_map = frame.map_from_local({far.x(), far.y(), *height(far)});
  EXPECT_NEAR(on_map.z(), 310, 2e-3);
  EXPECT_LT(*height(far), 9);
  EXPECT_FALSE(surface_in_world(&frame, {}));
  const SurfaceHeight as_map = surface_in_world(nullptr, [](const Vector2d& at) { return std::optional(at.x()); });
  EXPECT_EQ(*as_map({7, 8}), 7);
}

}  // namespace
}  // namespace collinea
