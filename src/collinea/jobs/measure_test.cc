// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/measure.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "collinea/base/file.h"
#include "collinea/base/test_folder.h"
#include "collinea/io/text.h"
#include "collinea/raster/geotiff.h"

namespace collinea {
namespace {

// A level surface of 20 x 10 m at 105 m, in cells of 0.5 m.
class Measured : public ::testing::Test {
 protected:
  Measured() {
    MapGrid grid;
    grid.west_m = 1000, grid.north_m = 2010, grid.cell_m = 0.5;
    grid.width = 40, grid.height = 20;
    for (const auto& [name, value] : {std::pair("dsm.tif", 105.0f), {"dsm_sigma.tif", 0.02f}, {"dtm.tif", 103.0f}}) {
      auto writer = GeoTiffWriter<float>::create(folder_ / name, grid, 1, {});
      EXPECT_TRUE(writer && writer->write(0, 0, FloatImage(40, 20, 1, value)) && writer->finish());
    }
    EXPECT_TRUE(
        write_file(folder_ / "area.csv", "easting, northing\n1005, 2002\n1015, 2002\n1015, 2008\n1005, 2008\n"));
  }
  [[nodiscard]] Result<MeasuredVolume> volume(const std::string& base, bool with_area) const {
    MeasureVolumeOptions asked{.base = base, .area = {}, .output = (folder_ / "volume.json").string()};
    if (with_area) asked.area = (folder_ / "area.csv").string();
    return measure_volume(folder_ / "dsm.tif", asked, {}, run_);
  }
  [[nodiscard]] nlohmann::json written() const { return nlohmann::json::parse(*read_file(folder_ / "volume.json")); }

  const TestFolder folder_;
  const collinea::Run run_;
};

TEST_F(Measured, ABaseIsALevelASurfaceOrTheRim) {
  ASSERT_TRUE(volume("102", true));
  EXPECT_NEAR(written().at("net_m3").get<double>(), 180, 1e-3);
  EXPECT_NEAR(written().at("area_m2").get<double>(), 60, 1e-3);
  ASSERT_TRUE(volume((folder_ / "dtm.tif").string(), false));
  EXPECT_NEAR(written().at("net_m3").get<double>(), 400, 1e-3);
  const auto rim = volume("rim", true);
  ASSERT_TRUE(rim) << rim.error().message;
  EXPECT_NEAR(written().at("net_m3").get<double>(), 0, 1e-3);
  EXPECT_NEAR(written().at("plane").at("height_m").get<double>(), 105, 1e-4);
  EXPECT_TRUE(rim->volume.plane);
  EXPECT_FALSE(rim->sigmas_assumed);
}

TEST_F(Measured, MistakesAreNamed) {
  EXPECT_NE(volume("rim", false).error().message.find("corners"), std::string::npos);
  EXPECT_NE(volume("nowhere.tif", false).error().message.find("nowhere.tif"), std::string::npos);
  ASSERT_TRUE(write_file(folder_ / "area.csv", "1, 2\n3, x\n"));
  EXPECT_NE(volume("102", true).error().message.find("line 2"), std::string::npos);
  EXPECT_FALSE(draw_profile(folder_ / "dsm.tif", {}, folder_ / "p", run_));
  EXPECT_FALSE(draw_profile(folder_ / "dsm.tif", {.line = "1,2,3"}, folder_ / "p", run_));
  EXPECT_FALSE(draw_profile(folder_ / "dsm.tif", {.line = "missing.csv"}, folder_ / "p", run_));
}

TEST_F(Measured, AProfileHasARowForEveryStepAndAColumnForEverySurface) {
  const ProfileOptions options{.line = "1002,2005,1012,2005", .others = (folder_ / "dtm.tif").string(), .step_m = 1.0};
  const auto done = draw_profile(folder_ / "dsm.tif", options, folder_ / "p", run_);
  ASSERT_TRUE(done) << done.error().message;
  EXPECT_NEAR(done->distance_m.back(), 10, 1e-9);
  const std::string text = *read_file(folder_ / "p" / "profile.csv");
  const auto lines = lines_of(text);
  ASSERT_GE(lines.size(), 12u);
  EXPECT_EQ(lines[0], "distance_m,east_m,north_m,dsm_height_m,dsm_sigma_m,dtm_height_m,dtm_sigma_m");
  EXPECT_EQ(lines[3], "2.0000,1004.0000,2005.0000,105.0000,0.0200,103.0000,0.0300");
  EXPECT_NE(read_file(folder_ / "p" / "profile.html")->find("<svg"), std::string::npos);
}

TEST_F(Measured, AProfileQuotesNamesOfSurfacesThatWouldBreakItsTitles) {
  const std::filesystem::path odd = folder_ / "north, \"high\"\nrim.tif";
  std::filesystem::copy_file(folder_ / "dsm.tif", odd);
  const ProfileOptions options{.line = "1002,2005,1012,2005", .step_m = 1.0};
  const auto done = draw_profile(odd, options, folder_ / "p", run_);
  ASSERT_TRUE(done) << done.error().message;
  const std::string text = *read_file(folder_ / "p" / "profile.csv"),
                    titles =
                        "distance_m,east_m,north_m,\"north, \"\"high\"\"\nrim_height_m\","
                        "\"north, \"\"high\"\"\nrim_sigma_m\"\n";
  EXPECT_TRUE(text.starts_with(titles)) << text.substr(0, 200);
}

}  // namespace
}  // namespace collinea
