// SPDX-License-Identifier: Apache-2.0
#include "collinea/synthetic/write.h"

#include <gtest/gtest.h>

#include <cmath>

#include "collinea/base/file.h"
#include "collinea/base/test_folder.h"
#include "collinea/io/control_file.h"
#include "collinea/raster/geotiff.h"
#include "collinea/raster/image_file.h"

namespace collinea {
namespace {

SurveyOptions tiny_survey() {
  SurveyOptions o;
  o.images = 12;
  o.gsd_m = 0.3;
  o.camera.width_px = 160;
  o.camera.height_px = 120;
  o.control_points = 3;
  o.check_points = 2;
  return o;
}

TEST(Write, WhatWasWrittenIsReadBack) {
  const TestFolder folder;
  const SurveyOptions options = tiny_survey();
  const auto done = simulate(options, folder / "survey", {});
  ASSERT_TRUE(done) << done.error().message;
  const Truth truth = *make_survey(options);
  const auto read = read_truth(folder / "survey");
  ASSERT_TRUE(read) << read.error().message;

  EXPECT_EQ(read->camera.params, truth.block.cameras.begin()->second.params);
  EXPECT_EQ(read->camera.width_px, 160);
  EXPECT_EQ(read->georeference.crs, options.site.crs);
  ASSERT_EQ(read->cam_from_world.size(), 12u);
  for (const auto& [id, image] : truth.block.images) {
    const Eigen::Vector3d centre = centre_of(pose_of(truth.block, id));
    EXPECT_LT((centre_of(read->cam_from_world.at(image.file)) - centre).norm(), 1e-9);
    EXPECT_LT((read->centre_in_map.at(image.file) - truth.frame.map_from_local(centre)).norm(), 2e-6);
  }
  ASSERT_EQ(read->marks.size(), 5u);
  for (const auto& [id, position] : truth.marks_in_world)
    EXPECT_LT((read->marks.at(truth.block.control.at(id).name).position_in_world - position).norm(), 2e-6);
  EXPECT_TRUE(std::filesystem::exists(read->dsm));
  EXPECT_TRUE(std::filesystem::exists(read->ortho));
}

TEST(Write, ControlIsWhatTheReaderExpects) {
  const TestFolder folder;
  const Truth truth = *make_survey(tiny_survey());
  ASSERT_TRUE(write_tables(truth, folder / "survey"));
  const auto control = read_control(folder / "survey" / "control.csv");
  ASSERT_TRUE(control) << control.error().message;
  EXPECT_EQ(control->crs, "EPSG:32633");
  ASSERT_EQ(control->points.size(), 5u);
  ASSERT_EQ(control->observations.size(), truth.block.control_observations.size());
  for (std::size_t i = 0; i < 5; ++i) {
    const ControlPoint& point = truth.block.control.at(ControlId{std::uint32_t(i)});
    EXPECT_EQ(control->points[i].name, point.name);
    EXPECT_EQ(control->points[i].role, point.role);
    EXPECT_LT((control->points[i].position_in_map - point.position_in_map).norm(), 1e-4);
    EXPECT_LT((control->points[i].sigma_m - point.sigma_m).norm(), 1e-9);
  }
  for (std::size_t i = 0; i < control->observations.size(); ++i)
    EXPECT_LT((control->observations[i].pixel - truth.block.control_observations[i].pixel).norm(), 1e-3);
}

// EXIF and XMP hold degrees to 1e-8 or better, heights to a millimetre.
TEST(Write, SmallAndVanishingSigmasOfControlCanBeReadToo) {
  for (const double sigma : {0.0, 0.00003}) {
    const TestFolder folder;
    SurveyOptions options = tiny_survey();
    options.control_sigma_plan_m = options.control_sigma_height_m = options.measurement_sigma_px = sigma;
    ASSERT_TRUE(write_tables(*make_survey(options), folder / "survey"));
    const auto control = read_control(folder / "survey" / "control.csv");
    EXPECT_TRUE(control) << control.error().message;
  }
}

TEST(Write, WhatAnEarlierSimulationLeftGoes) {
  const TestFolder folder;
  SurveyOptions options = tiny_survey();
  ASSERT_TRUE(simulate(options, folder / "survey", {}));
  ASSERT_TRUE(write_file(folder / "survey/images/IMG_0999.jpg", "the user's own"));
  const FacadeOptions facade{
      .stations = 4, .camera = {.width_px = 160, .height_px = 120}, .control_points = 0, .check_points = 0};
  const auto done = simulate(facade, folder / "survey", {});
  ASSERT_TRUE(done) << done.error().message;
  const auto read = read_truth(folder / "survey");
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->cam_from_world.size(), 8u);
  EXPECT_TRUE(read->dsm.empty());
  EXPECT_TRUE(read->ortho.empty());
  EXPECT_TRUE(std::filesystem::exists(folder / "survey/images/IMG_0008.jpg"));
  EXPECT_FALSE(std::filesystem::exists(folder / "survey/images/IMG_0009.jpg"));
  EXPECT_TRUE(std::filesystem::exists(folder / "survey/images/IMG_0999.jpg"));
}

TEST(Write, ImagesSayWhereTheyWereTaken) {
  const TestFolder folder;
  const Truth truth = *make_survey(tiny_survey());
  std::filesystem::create_directories(folder / "images");
  ASSERT_TRUE(write_images(truth, folder / "images", {}));
  for (const auto& [id, image] : truth.block.images) {
    const auto header = read_image_header(folder / "images" / image.file);
    ASSERT_TRUE(header) << header.error().message;
    EXPECT_EQ(header->width_px, 160);
    EXPECT_EQ(header->maker, "Collinea");
    EXPECT_EQ(header->taken.substr(0, 19), image.taken.substr(0, 19));
    ASSERT_TRUE(header->latitude_deg && header->longitude_deg && header->height_m);
    EXPECT_NEAR(*header->latitude_deg, image.position->latitude_deg, 2e-8);
    EXPECT_NEAR(*header->longitude_deg, image.position->longitude_deg, 2e-8);
    EXPECT_NEAR(*header->height_m, image.position->height_m, 2e-3);
    ASSERT_TRUE(header->heading_deg && header->pitch_deg);
    EXPECT_NEAR(std::remainder(*header->heading_deg - image.attitude->heading_deg, 360), 0, 0.06);
    EXPECT_NEAR(*header->pitch_deg, image.attitude->pitch_deg, 0.06);
    EXPECT_FALSE(header->sigma_east_m);
  }
}

// Heights of 300 m in float: steps of 3e-5 m. A cell whose centre lies on a wall's edge may see roof or ground.
TEST(Write, TheSurfaceRasterIsTheSurface) {
  const TestFolder folder;
  const Truth truth = *make_survey(tiny_survey());
  ASSERT_TRUE(write_products(truth, folder / "", 0.3, {}));
  const auto dsm = GeoTiffReader::open(folder / "dsm.tif");
  ASSERT_TRUE(dsm) << dsm.error().message;
  const MapGrid& grid = dsm->grid();
  const auto heights = dsm->read_float(0, 0, grid.width, grid.height);
  ASSERT_TRUE(heights) << heights.error().message;
  int compared = 0, apart = 0;
  for (int row = 0; row < grid.height; row += 3)
    for (int column = 0; column < grid.width; column += 3) {
      const double height = heights->at(column, row);
      ASSERT_NE(height, *dsm->nodata());
      const Eigen::Vector3d local =
          truth.frame.local_from_map({grid.east_of(column + 0.5), grid.north_of(row + 0.5), height});
      apart += std::abs(local.z() - truth.scene.surface_height(local.x(), local.y())) > 1e-4;
      ++compared;
    }
  EXPECT_GT(compared, 1000);
  EXPECT_LT(apart, compared / 500);
}

TEST(Write, TheTerrainRasterIsTheTerrainUnderTheSurface) {
  const TestFolder folder;
  const Truth truth = *make_survey(tiny_survey());
  ASSERT_TRUE(write_products(truth, folder / "", 0.3, {}));
  const auto dtm = GeoTiffReader::open(folder / "dtm.tif"), dsm = GeoTiffReader::open(folder / "dsm.tif");
  ASSERT_TRUE(dtm && dsm);
  const MapGrid& grid = dtm->grid();
  const auto ground = dtm->read_float(0, 0, grid.width, grid.height);
  const auto surface = dsm->read_float(0, 0, grid.width, grid.height);
  ASSERT_TRUE(ground && surface);
  int covered = 0;
  for (int row = 0; row < grid.height; row += 3)
    for (int column = 0; column < grid.width; column += 3) {
      const double height = ground->at(column, row);
      const Eigen::Vector3d local =
          truth.frame.local_from_map({grid.east_of(column + 0.5), grid.north_of(row + 0.5), height});
      ASSERT_NEAR(local.z(), truth.scene.terrain_height(local.x(), local.y()), 1e-4);
      ASSERT_LT(height, surface->at(column, row) + 1e-4);
      covered += surface->at(column, row) > height + 1;
    }
  EXPECT_GT(covered, 10);
}

TEST(Write, BrokenTruthNamesItsLine) {
  const TestFolder folder;
  const Truth truth = *make_survey(tiny_survey());
  ASSERT_TRUE(write_tables(truth, folder / "survey"));
  std::FILE* file = std::fopen((folder / "survey" / "truth" / "poses.csv").c_str(), "a");
  std::fputs("IMG_9999.jpg, 1, 2, x\n", file);
  std::fclose(file);
  const auto read = read_truth(folder / "survey");
  ASSERT_FALSE(read);
  EXPECT_NE(read.error().message.find("poses.csv: line 14"), std::string::npos) << read.error().message;
  EXPECT_FALSE(read_truth(folder / "nowhere"));
}

}  // namespace
}  // namespace collinea
