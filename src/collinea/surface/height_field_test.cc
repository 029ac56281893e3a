// SPDX-License-Identifier: Apache-2.0
#include "collinea/surface/height_field.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "collinea/base/test_folder.h"

namespace collinea {
namespace {

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

TEST(HeightField, HeightsAreBilinearOnSlopesAndSharpAtSteps) {
  FloatImage heights(20, 20);
  for (int y = 0; y < 20; ++y)
    for (int x = 0; x < 20; ++x) heights.at(x, y) = 0.5f * float(x) + (x >= 10 ? 8.0f : 0.0f);
  heights.at(3, 3) = kNone;
  const auto at = [&](double x, double y) { return height_at(heights, x, y, 1); };
  EXPECT_FLOAT_EQ(at(6.25, 7.0), 0.5f * 5.75f);
  EXPECT_FLOAT_EQ(at(9.9, 7.5), 4.5f);
  EXPECT_FLOAT_EQ(at(10.1, 7.5), 13.0f);
  EXPECT_TRUE(std::isnan(at(3.5, 3.5)));
  EXPECT_FLOAT_EQ(at(4.1, 3.5), 2.0f);
  EXPECT_TRUE(std::isnan(at(-1, 3)));
}

TEST(Overview, KnowsRangeAndAPositionOfEachBlock) {
  HeightField field;
  field.grid = {0, 0, 1, 70, 300, ""};
  field.read = [](int column, int row, int width, int height) -> Result<FloatImage> {
    FloatImage heights(width, height);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        heights.at(x, y) = column + x >= 64 ? kNone : float(column + x + 1000 * (row + y));
    return heights;
  };
  const auto result = overview(field, collinea::Run{});
  ASSERT_TRUE(result);
  EXPECT_EQ(result->lowest_m.width, 3);
  EXPECT_EQ(result->lowest_m.height, 10);
  EXPECT_EQ(result->lowest_m.at(1, 8), 256'032);
  EXPECT_EQ(result->highest_m.at(1, 8), 287'063);
  EXPECT_TRUE(std::isnan(result->highest_m.at(2, 0)));
  ASSERT_EQ(result->samples.size(), 20u);
  EXPECT_EQ(result->samples[3].column, 48.5);
  EXPECT_EQ(result->samples[3].row, 48.5);
}

TEST(HeightField, ThinnedKeepsEveryFourthHeightAndTheCorner) {
  HeightField field;
  field.grid = {500, 900, 0.5, 70, 301, ""};
  field.read = [](int column, int row, int width, int height) -> Result<FloatImage> {
    EXPECT_TRUE(column >= 0 && row >= 0 && column + width <= 70 && row + height <= 301);
    FloatImage heights(width, height);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) heights.at(x, y) = float(column + x + 1000 * (row + y));
    return heights;
  };
  const HeightField thin = thinned(field, 4);
  EXPECT_EQ(thin.grid.width, 18);
  EXPECT_EQ(thin.grid.height, 76);
  EXPECT_EQ(thin.grid.cell_m, 2);
  EXPECT_EQ(thin.grid.west_m, 500);
  EXPECT_EQ(thin.grid.north_m, 900);
  EXPECT_FALSE(thin.read_sigma);
  const auto part = thin.read(3, 1, 15, 75);  // more than one strip, and to the last cells
  ASSERT_TRUE(part);
  EXPECT_EQ(part->at(0, 0), 14 + 1000 * 6);
  EXPECT_EQ(part->at(1, 70), 18 + 1000 * (4 * 71 + 2));
  EXPECT_EQ(part->at(14, 74), 69 + 1000 * 300);
}

TEST(HeightField, UnpackedIsTheSameAndLeavesNoFile) {
  const TestFolder folder;
  HeightField field;
  field.grid = {500, 900, 0.5, 70, 301, ""};
  const auto reader = [](float more) {
    return [more](int column, int row, int width, int height) -> Result<FloatImage> {
      FloatImage heights(width, height);
      for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
          heights.at(x, y) = column + x == 7 ? kNone : more + float(column + x + 1000 * (row + y));
      return heights;
    };
  };
  field.read = reader(0);
  {
    const auto exact = unpacked(field, folder / "scratch", collinea::Run{});
    ASSERT_TRUE(exact);
    EXPECT_FALSE(exact->read_sigma);
  }
  field.read_sigma = reader(0.25f);
  {
    const auto kept = unpacked(field, folder / "scratch", collinea::Run{});
    ASSERT_TRUE(kept && kept->read_sigma);
    EXPECT_EQ(kept->grid.width, 70);
    EXPECT_EQ(kept->grid.cell_m, 0.5);
    for (const auto& [column, row] : {std::pair(8, 0), std::pair(30, 226)}) {
      const auto heights = kept->read(column, row, 40, 75), sigmas = kept->read_sigma(column, row, 40, 75);
      ASSERT_TRUE(heights && sigmas);
      EXPECT_EQ(heights->data, field.read(column, row, 40, 75)->data);
      EXPECT_EQ(sigmas->data, field.read_sigma(column, row, 40, 75)->data);
    }
    EXPECT_TRUE(std::isnan(kept->read(7, 300, 1, 1)->at(0, 0)));
    EXPECT_TRUE(std::filesystem::is_empty((folder / "scratch").parent_path()));
  }
  EXPECT_FALSE(unpacked(field, folder / "none" / "scratch", collinea::Run{}));
}

TEST(HeightField, SigmasOfAnotherModelAreRefusedInWords) {
  const TestFolder folder;
  const auto write = [&](const std::string& name, const MapGrid& grid) {
    auto writer = GeoTiffWriter<float>::create(folder / name, grid, 1, {});
    return writer && writer->write(0, 0, FloatImage(grid.width, grid.height, 1, 5)) && writer->finish();
  };
  const MapGrid grid{500'000.5, 5'000'000, 0.05, 40, 30, ""};
  MapGrid moved = grid, coarser = grid, smaller = grid;
  moved.north_m += grid.cell_m;
  coarser.cell_m = 0.051;
  smaller.height = 29;
  ASSERT_TRUE(write("dsm.tif", grid) && write("sigma.tif", grid));
  EXPECT_TRUE(open_height_field(folder / "dsm.tif", folder / "sigma.tif")->read_sigma);
  for (const MapGrid& other : {moved, coarser, smaller}) {
    ASSERT_TRUE(write("other.tif", other));
    const auto refused = open_height_field(folder / "dsm.tif", folder / "other.tif");
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, Errc::kBadInput);
    EXPECT_NE(refused.error().message.find("does not lie on"), std::string::npos) << refused.error().message;
  }
}

}  // namespace
}  // namespace collinea
