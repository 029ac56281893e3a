// SPDX-License-Identifier: Apache-2.0
#include "collinea/surface/profile.h"

#include <gtest/gtest.h>

#include <cmath>

#include "collinea/base/test_folder.h"

namespace collinea {
namespace {

// A plane over 20 x 15 m with a hole, cells of 0.5 m: bilinear reading is exact.
class ProfileOfAPlane : public ::testing::Test {
 protected:
  ProfileOfAPlane() {
    MapGrid grid;
    grid.west_m = 100, grid.north_m = 215, grid.cell_m = 0.5;
    grid.width = 40, grid.height = 30;
    FloatImage heights(40, 30), sigmas(40, 30);
    for (int y = 0; y < 30; ++y)
      for (int x = 0; x < 40; ++x) {
        heights.at(x, y) = float(height_m({grid.east_of(x + 0.5), grid.north_of(y + 0.5)}));
        if (x >= 30) heights.at(x, y) = -9999;
        sigmas.at(x, y) = float(0.01 + 0.001 * x);
      }
    for (const auto& [name, raster] : {std::pair("dem.tif", &heights), {"dem_sigma.tif", &sigmas}}) {
      auto writer = GeoTiffWriter<float>::create(folder_ / name, grid, 1, {.nodata = -9999});
      EXPECT_TRUE(writer && writer->write(0, 0, *raster) && writer->finish());
    }
    surfaces_.push_back(HeightSamples::open(with_sigmas_beside(folder_ / "dem.tif"), 1).value());
  }
  static double height_m(const Eigen::Vector2d& position) {
    return 50 + 0.25 * (position.x() - 100) - 0.5 * (position.y() - 200);
  }

  const TestFolder folder_;
  std::vector<HeightSamples> surfaces_;
};

TEST_F(ProfileOfAPlane, HeightsAreThoseOfThePlaneAndDistancesThoseOfTheLine) {
  const std::vector<Eigen::Vector2d> line = {{102, 202}, {105, 206}, {105, 214}};
  const Profile profile = profile_along(line, 0.4, surfaces_).value();
  EXPECT_EQ(profile.distance_m.front(), 0);
  EXPECT_NEAR(profile.distance_m.back(), 13, 1e-12);
  EXPECT_EQ(profile.distance_m.size(), 1u + 13 + 20);
  bool corner = false;
  for (std::size_t i = 0; i < profile.positions.size(); ++i) {
    EXPECT_NEAR(profile.of[0][i].height_m, height_m(profile.positions[i]), 1e-4) << i;
    EXPECT_NEAR(profile.of[0][i].sigma_m, 0.01 + 0.001 * ((profile.positions[i].x() - 100) / 0.5 - 0.5), 1e-6);
    if (i > 0) {
      EXPECT_LE(profile.distance_m[i] - profile.distance_m[i - 1], 0.4 + 1e-9);
    }
    corner |= (profile.positions[i] - line[1]).norm() < 1e-9;
  }
  EXPECT_TRUE(corner);
}

TEST_F(ProfileOfAPlane, WhereThereIsNothingTheHeightIsNone) {
  const Profile profile = profile_along({{110, 205}, {130, 205}}, 0.5, surfaces_).value();
  EXPECT_TRUE(std::isfinite(profile.of[0].front().height_m));
  EXPECT_TRUE(std::isnan(profile.of[0][profile.of[0].size() / 2].height_m));  // the hole
  EXPECT_TRUE(std::isnan(profile.of[0].back().height_m));                     // off the raster
}

TEST_F(ProfileOfAPlane, ALineThatIsNoneIsRefused) {
  EXPECT_FALSE(profile_along({}, 0.5, surfaces_));
  EXPECT_FALSE(profile_along({{110, 205}}, 0.5, surfaces_));
  EXPECT_FALSE(profile_along({{110, 205}, {110, 205}}, 0.5, surfaces_));
  EXPECT_FALSE(profile_along({{110, 205}, {119, 205}}, 1e-7, surfaces_));
}

TEST_F(ProfileOfAPlane, AnImageIsNoSurface) {
  MapGrid grid;
  grid.width = grid.height = 4;
  auto writer = GeoTiffWriter<float>::create(folder_ / "rgb.tif", grid, 3, {});
  ASSERT_TRUE(writer && writer->write(0, 0, FloatImage(4, 4, 3)) && writer->finish());
  const auto opened = HeightSamples::open({folder_ / "rgb.tif"}, 0.1);
  ASSERT_FALSE(opened);
  EXPECT_NE(opened.error().message.find("3 bands"), std::string::npos);
}

TEST_F(ProfileOfAPlane, SigmasOfAnotherRasterAreRefused) {
  const MapGrid right{100, 215, 0.5, 40, 30, ""};
  const MapGrid wrong[] = {{101, 215, 0.5, 40, 30, ""},
                           {100, 214.5, 0.5, 40, 30, ""},
                           {100, 215, 0.51, 40, 30, ""},
                           {100, 215, 0.5, 39, 30, ""}};
  const auto opened_with = [&](const MapGrid& grid) {
    const auto file = folder_ / "other_sigma.tif";
    auto writer = GeoTiffWriter<float>::create(file, grid, 1, {});
    EXPECT_TRUE(writer && writer->write(0, 0, FloatImage(grid.width, grid.height)) && writer->finish());
    return HeightSamples::open({folder_ / "dem.tif", file}, 1);
  };
  EXPECT_TRUE(opened_with(right));
  for (const MapGrid& grid : wrong) {
    const auto opened = opened_with(grid);
    ASSERT_FALSE(opened) << grid.west_m << " " << grid.north_m << " " << grid.cell_m << " " << grid.width;
    EXPECT_NE(opened.error().message.find("does not lie over"), std::string::npos);
  }
}

TEST_F(ProfileOfAPlane, SigmasAreThoseStatedWhereNoRasterSaysThem) {
  std::vector<HeightSamples> plain;
  plain.push_back(HeightSamples::open({folder_ / "dem.tif"}, 0.07).value());
  const Profile profile = profile_along({{102, 202}, {105, 206}}, 1, plain).value();
  EXPECT_NEAR(profile.of[0][2].sigma_m, 0.07, 1e-7);
  EXPECT_FALSE(HeightSamples::open({folder_ / "nowhere.tif"}, 0.07));
}

}  // namespace
}  // namespace collinea
