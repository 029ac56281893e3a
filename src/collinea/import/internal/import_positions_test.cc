// SPDX-License-Identifier: Apache-2.0
#include "collinea/import/internal/import_positions.h"

#include <gtest/gtest.h>

#include <cmath>

#include "collinea/base/file.h"
#include "collinea/block/image_axes.h"
#include "collinea/block/world_frame.h"

namespace collinea {
namespace {

Imported images(const std::vector<std::string>& files) {
  Imported imported;
  for (std::uint32_t i = 0; i < files.size(); ++i) imported.block.images[{i}].file = files[i];
  return imported;
}

TEST(ImportPositions, PositionsOfAMapBecomeGeographicWithTheSigmasOfTheFile) {
  Imported imported = images({"flight/a.jpg", "flight/b.jpg", "c.jpg"});
  const auto file = parse_positions(
      "# collinea positions, EPSG:32633\nimage,easting_m,northing_m,height_m,sigma_m,taken\n"
      "a.jpg,500000,5300000,420,0.02,2024:05:17 10:31:08\nB.JPG,500010,5300000,420,,\nz.jpg,500000,5300000,420,1,\n");
  ASSERT_TRUE(file);
  ASSERT_TRUE(add_positions(imported, *file, "gnss.csv", {}));
  const auto& a = imported.block.images.at({0}).position;
  ASSERT_TRUE(a && imported.block.images.at({1}).position && !imported.block.images.at({2}).position);
  EXPECT_NEAR(a->longitude_deg, 15, 1e-9);  // the central meridian
  EXPECT_NEAR(a->height_m, 420, 1e-6);
  EXPECT_EQ(a->sigma_m, Eigen::Vector3d(0.02, 0.02, 0.02));
  EXPECT_EQ(imported.block.images.at({1}).position->sigma_m, Eigen::Vector3d(2, 2, 4));  // by default
  EXPECT_TRUE(imported.block.images.at({0}).taken.empty());                              // the others have no time
  ASSERT_EQ(imported.findings.size(), 3u);
  EXPECT_EQ(imported.findings[0],
            finding_of(FindingCode::kPositionsOfOthers, {Subject::file("gnss.csv"), Subject::file("z.jpg")},
                       {{FigureName::kCount, 1}, {FigureName::kOf, 3}}));
}

// Three degrees east of the central meridian grid north is 2.2 degrees off true north.
TEST(ImportPositions, AnglesToTheMapKnowTheConvergenceOfMeridians) {
  Imported imported = images({"a.jpg"});
  imported.block.images.at({0}).position = PositionPrior{{0, 0, 300}, {1, 1, 1}, 48, 18, 300};
  imported.block.georeference = Georeference{"EPSG:32633", 48, 18, 0};
  const auto file = parse_positions("image,omega_deg,phi_deg,kappa_deg,sigma_attitude_deg\na.jpg,0,0,0,0.05\n");
  ASSERT_TRUE(file);
  ASSERT_TRUE(add_map_attitudes(imported, *file));
  const auto& attitude = imported.block.images.at({0}).attitude;
  ASSERT_TRUE(attitude);
  const Eigen::Vector3d upper_edge = cam_from_world(*attitude).conjugate() * Eigen::Vector3d(0, -1, 0);
  const double convergence = 3 * std::sin(48 * std::numbers::pi / 180) * std::numbers::pi / 180;
  EXPECT_NEAR(std::atan2(upper_edge.x(), upper_edge.y()), convergence, 1e-4);
  EXPECT_EQ(attitude->sigma_deg, Eigen::Vector3d(0.05, 0.05, 0.05));
}

std::string stamp(int number) {
  return std::to_string(number) + "\t" + std::to_string(1000 + number) +
         "\t[2211]\t0,N\t0,E\t0,V\t47.6,Lat\t16.4,Lon\t513,Ellh\t0.014,0.013,0.029\t50,Q\n";
}

TEST(ImportPositions, ExposuresBelongToTheImagesWithTheirNumbers) {
  const auto file = parse_positions(stamp(1) + stamp(2));
  ASSERT_TRUE(file);
  Imported one = images({"MAX_0001.JPG", "MAX_0002.JPG"});
  ASSERT_TRUE(add_positions(one, *file, "101FTASK_Timestamp.mrk", {}));
  EXPECT_TRUE(one.findings.empty());
  EXPECT_EQ(one.block.images.at({1}).taken, "2022:05:22 00:16:42.000000");
  Imported two = images({"101FTASK/MAX_0001.JPG", "102FTASK/MAX_0001.JPG", "102FTASK/MAX_0002.JPG"});
  ASSERT_TRUE(add_positions(two, *file, "101FTASK_Timestamp.mrk", {}));
  EXPECT_TRUE(two.block.images.at({0}).position);
  EXPECT_FALSE(two.block.images.at({1}).position);
  Imported other = images({"x.jpg"});
  const auto refused = add_positions(other, *file, "101FTASK_Timestamp.mrk", {});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().message,
            "101FTASK_Timestamp.mrk: none of its 2 images is among the photographs; the first is 1");
}

TEST(ImportPositions, WhatTheFileLeavesOpenIsAsked) {
  Imported imported = images({"a.jpg"});
  const auto file = parse_positions("image,easting_m,northing_m,height_m\na.jpg,500000,5300000,420\n");
  ASSERT_TRUE(file);
  const auto refused = add_positions(imported, *file, "gnss.csv", {});
  ASSERT_FALSE(refused);
  EXPECT_TRUE(refused.error().message.starts_with("gnss.csv: line 2: eastings and northings of which map?"))
      << refused.error().message;
  EXPECT_TRUE(add_positions(imported, *file, "gnss.csv", {.crs = "EPSG:32633"}));
}

}  // namespace
}  // namespace collinea
