// SPDX-License-Identifier: Apache-2.0
#include "collinea/raster/hillshade.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "collinea/base/test_folder.h"
#include "collinea/raster/geotiff.h"

namespace collinea {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

// A plane that rises by so much per cell to the east and to the north.
FloatImage plane(int width, int height, double to_east, double to_north) {
  FloatImage heights(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) heights.at(x, y) = float(x * to_east - y * to_north);
  return heights;
}

TEST(Hillshade, IsTheCosineBetweenNormalAndLight) {
  // Cells of half a metre: slopes are twice the rise per cell.
  EXPECT_NEAR(hillshade_at(plane(3, 3, 0, 0), 1, 1, 0.5), std::sqrt(0.5), 1e-12);
  // Falls to the north-west by 45 degrees: faces the light. To the south-east: grazed by it. By 60 degrees: turned
  // away.
  const double s = std::sqrt(0.5) / 2;
  EXPECT_NEAR(hillshade_at(plane(3, 3, s, -s), 1, 1, 0.5), 1, 1e-6);
  EXPECT_NEAR(hillshade_at(plane(3, 3, -s, s), 1, 1, 0.5), 0, 1e-6);
  EXPECT_EQ(hillshade_at(plane(3, 3, -std::sqrt(3.0) * s, std::sqrt(3.0) * s), 1, 1, 0.5), 0);
  // Falls to the north by 45 degrees: (0, 1, 1) . (-1/2, 1/2, 1/sqrt 2) / sqrt 2.
  EXPECT_NEAR(hillshade_at(plane(3, 3, 0, -0.5), 1, 1, 0.5), (0.5 + std::sqrt(0.5)) / std::sqrt(2.0), 1e-6);
}

TEST(Hillshade, WhatIsNotThereIsAsHighAsTheMiddle) {
  FloatImage heights = plane(3, 3, 0, 0);
  heights.at(0, 0) = heights.at(2, 1) = kNaN;
  EXPECT_NEAR(hillshade_at(heights, 1, 1, 1), std::sqrt(0.5), 1e-12);
  EXPECT_NEAR(hillshade_at(heights, 0, 2, 1), std::sqrt(0.5), 1e-12);
  EXPECT_TRUE(std::isnan(hillshade_at(heights, 2, 1, 1)));
}

TEST(Hillshade, TilesMeetAndEmptyCellsStayEmpty) {
  const TestFolder folder;
  MapGrid grid{5000, 7000, 0.5, 700, 530, ""};
  FloatImage heights(grid.width, grid.height);
  for (int y = 0; y < grid.height; ++y)
    for (int x = 0; x < grid.width; ++x) heights.at(x, y) = float(3 * std::sin(x / 9.0) * std::cos(y / 7.0));
  heights.at(511, 300) = -9999;
  GeoTiffWriter<float>::Options options;
  options.nodata = -9999;
  auto writer = GeoTiffWriter<float>::create(folder / "z.tif", grid, 1, options).value();
  ASSERT_TRUE(writer.write(0, 0, heights) && writer.finish());
  const auto written = write_hillshade(folder / "z.tif", folder / "shade.tif", collinea::Run());
  ASSERT_TRUE(written) << written.error().message;
  const auto reader = GeoTiffReader::open(folder / "shade.tif").value();
  EXPECT_EQ(reader.grid().west_m, grid.west_m);
  EXPECT_EQ(reader.grid().cell_m, grid.cell_m);
  EXPECT_EQ(reader.nodata(), 0);
  const auto image = reader.read_byte(0, 0, grid.width, grid.height).value();
  heights.at(511, 300) = kNaN;
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      const double light = hillshade_at(heights, x, y, grid.cell_m);
      ASSERT_EQ(image.at(x, y), std::isnan(light) ? 0 : int(std::lround(1 + 254 * light))) << x << ' ' << y;
    }
  }
}

TEST(Hillshade, AFileThatIsNotThereIsNamed) {
  const TestFolder folder;
  const auto written = write_hillshade(folder / "none.tif", folder / "shade.tif", collinea::Run());
  ASSERT_FALSE(written);
  EXPECT_NE(written.error().message.find("none.tif"), std::string::npos) << written.error().message;
}

}  // namespace
}  // namespace collinea
