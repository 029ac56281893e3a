// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/elevation.h"

#include <gtest/gtest.h>

#include "collinea/base/file.h"
#include "collinea/base/test_folder.h"
#include "collinea/raster/geotiff.h"

namespace collinea {
namespace {

TEST(Elevation, TheLargestUsualScaleThatFitsOnA3IsTaken) {
  const ElevationSheet house = elevation_sheet(12, 8, {});  // 240 x 160 mm at 1:50
  EXPECT_EQ(house.scale, 50);
  EXPECT_EQ(house.paper, "A3");
  EXPECT_GT(house.width_mm, house.height_mm);
  EXPECT_EQ(elevation_sheet(60, 20, {}).scale, 200);
  EXPECT_EQ(elevation_sheet(0.03, 0.03, {}).scale, 1);
  EXPECT_EQ(elevation_sheet(5, 5, {}).scale, 20);
  EXPECT_EQ(elevation_sheet(6.5, 6.5, {}).scale, 25);
  const ElevationSheet tower = elevation_sheet(8, 30, {});
  EXPECT_EQ(tower.scale, 100);
  EXPECT_LT(tower.width_mm, tower.height_mm);
}

TEST(Elevation, AScaleThatIsAskedForGetsThePaperItNeeds) {
  EXPECT_EQ(elevation_sheet(12, 8, 20).paper, "A1");
  EXPECT_EQ(elevation_sheet(12, 8, 100).paper, "A4");
  const ElevationSheet banner = elevation_sheet(100, 8, 20);
  EXPECT_EQ(banner.paper, "");
  EXPECT_GT(banner.width_mm, 5000);
  EXPECT_TRUE(banner.fits_in_a_pdf());
  EXPECT_FALSE(elevation_sheet(100, 8, 10).fits_in_a_pdf());
}

class Drawn : public testing::Test {
 protected:
  void SetUp() override {
    MapGrid grid{.west_m = -0.5, .north_m = 8.5, .cell_m = 0.05, .width = 260, .height = 180, .wkt = ""};
    auto writer = GeoTiffWriter<std::uint8_t>::create(ortho_, grid, 4, {.alpha = true});
    Raster<std::uint8_t> pixels(grid.width, grid.height, 4, 200);
    ASSERT_TRUE(writer && writer->write(0, 0, pixels) && writer->finish());
    frame_.name = "south";
    frame_.width_m = 13;
    frame_.height_m = 9;
  }
  Result<double> drawn(const std::string& file, const std::string& project, bool is_metric = true) {
    return write_elevation(frame_, ortho_, project, is_metric, {}, folder_ / file);
  }
  const TestFolder folder_;
  const std::filesystem::path ortho_ = folder_ / "ortho.tif";
  FrameRecord frame_;
};

TEST_F(Drawn, IsAPdfOfTheSameBytesEachTime) {
  const auto scale = drawn("a.pdf", "Haus Müller");
  ASSERT_TRUE(scale) << scale.error().message;
  EXPECT_EQ(*scale, 50);
  ASSERT_TRUE(drawn("b.pdf", "Haus Müller"));
  const std::string bytes = read_file(folder_ / "a.pdf").value();
  EXPECT_TRUE(bytes.starts_with("%PDF-"));
  EXPECT_NE(bytes.find("%%EOF"), std::string::npos);
  EXPECT_EQ(bytes, read_file(folder_ / "b.pdf").value());
  EXPECT_EQ(bytes.find("CreationDate"), std::string::npos);
  ASSERT_TRUE(drawn("c.pdf", "Другой"));  // letters that the fonts of PDF do not have
}

TEST_F(Drawn, WithoutAnOrthophotoIsAnError) {
  std::filesystem::remove(ortho_);
  EXPECT_FALSE(drawn("a.pdf", "house"));
  EXPECT_FALSE(is_there(folder_ / "a.pdf"));
}

}  // namespace
}  // namespace collinea
