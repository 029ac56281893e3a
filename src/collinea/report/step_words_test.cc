// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/step_words.h"

#include <gtest/gtest.h>

#include <limits>

#include "collinea/adjust/observation_group.h"
#include "collinea/report/step_figures.h"

namespace collinea {
namespace {

TEST(StepWords, SayOnOneLineWhatCameOfAStep) {
  ImportRecord imported{.images = 6, .cameras = 1, .positions = 5, .control_points = 4};
  EXPECT_EQ(summary_of(imported), "6 images, 1 camera, 5 positions, 4 control points, no map: local gauge");
  imported.cameras = 2;
  imported.geodetic_observations = 3;
  imported.crs = "EPSG:32633";
  EXPECT_EQ(summary_of(imported),
            "6 images, 2 cameras, 5 positions, 4 control points, 3 measurements on the ground, map EPSG:32633");
  EXPECT_EQ(summary_of(DetectRecord{.images = 6, .features = 1234}), "1234 features in 6 images");
  EXPECT_EQ(summary_of(DetectRecord{.images = 1, .features = 1}), "1 feature in 1 image");
  EXPECT_EQ(summary_of(MatchRecord{.pairs_searched = 9, .matches = 700, .pairs_by_geometry = {3, 4, 1, 1}}),
            "6 pairs verified, 9 searched, 700 matches");
  EXPECT_EQ(
      summary_of(OrientationRecord{
          .images = 6, .oriented = 5, .tie_points = 99, .mean_reprojection_px = 0.456, .gauge = {.given_by = "model"}}),
      "5 of 6 images, 99 tie points, mean residual 0.46 px, local gauge, as given by model");
  EXPECT_EQ(summary_of(DensifyRecord{.depth_maps = 5, .points = 1000}), "5 depth maps, 1000 points");
  EXPECT_EQ(summary_of(ReportRecord{"report/report.html"}), "report/report.html");
}

TEST(StepWords, SayHowMuchOfAProductIsMeasured) {
  EXPECT_EQ(summary_of(SurfaceRecord{
                .cell_m = 0.25, .width = 40, .height = 30, .measured_cells = 900, .interpolated_cells = 100}),
            "40 x 30 cells of 0.25 m, 10.0 % of the seen ones interpolated");
  EXPECT_EQ(summary_of(SurfaceRecord{.cell_m = 0.25, .width = 4, .height = 3}),
            "4 x 3 cells of 0.25 m, 0.0 % of the seen ones interpolated");
  TerrainRecord terrain{.width = 40, .height = 30, .ground_cells = 750, .interpolated_cells = 250};
  EXPECT_EQ(summary_of(terrain), "ground seen in 75.0 % of 40 x 30 cells");
  terrain.contour_m = 0.5;
  EXPECT_EQ(summary_of(terrain), "ground seen in 75.0 % of 40 x 30 cells, contours every 0.5 m");
  OrthoRecord ortho{.cell_m = 0.1,
                    .width = 4,
                    .height = 3,
                    .painted_cells = 200,
                    .images_used = 5,
                    .seam_length_m = 12.3,
                    .seam_difference_grey = 1.25};
  const std::string found = summary_of(ortho);
  EXPECT_EQ(found,
            "4 x 3 cells of 0.1 m from 5 photographs, 12 m of seams along which these differ by 1.2 grey levels");
  ortho.seamlines = {"edited.gpkg", 7};
  ortho.cells_not_followed = {{{1}, 2}, {{4}, 1}};
  EXPECT_EQ(summary_of(ortho), found +
                                   ", as 7 polygons of edited.gpkg say but for 1.50 % of the cells, which their "
                                   "photograph does not see");
}

TEST(StepWords, SayWhyAStepWasSkipped) {
  const TerrainRecord none{.skipped_because = finding_of(FindingCode::kNoScale, {Product::kTerrainModel}), .width = 3};
  EXPECT_EQ(summary_of(none), "The block has no scale, so that the size of objects is not known: no terrain model.");
}

Block two_images() {
  Block block;
  block.images[{1}].file = "a.jpg";
  block.images[{4}].file = "b.jpg";
  return block;
}

TEST(StepFigures, NameImagesByTheirFiles) {
  OrthoRecord ortho{.cell_m = 0.1, .images_used = 2, .cells_not_followed = {{{4}, 3}}, .sources = {{1}, {4}, {9}}};
  const auto figures = figures_of(ortho, two_images());
  EXPECT_EQ(figures.at("sources").dump(), R"(["a.jpg","b.jpg","image 9"])");
  EXPECT_EQ(figures.at("cells_not_followed").dump(), R"({"b.jpg":3})");
  EXPECT_EQ(figures.at("images_used"), 2);
  EXPECT_TRUE(figures.at("seamlines").is_null());
  EXPECT_FALSE(figures.contains("skipped_because"));
}

TEST(StepFigures, AreNullWhereNothingIsKnown) {
  OrientationRecord record{.oriented = 2, .pixel_size = 0.5};
  record.other_parts = {{{1}, {4}}};
  record.sigma_factors["control_images"] = 2.5;
  record.instruments.lever_arm = "0,0,0.1";
  const auto figures = figures_of(record, two_images());
  EXPECT_EQ(figures.at("oriented"), 2);
  EXPECT_EQ(figures.at("sigma_factors").size(), kObservationGroups);  // in their order
  EXPECT_EQ(figures.at("sigma_factors")[0], 1.0);
  EXPECT_EQ(figures.at("sigma_factors")[1], 2.5);
  EXPECT_EQ(figures.at("instruments").at("lever_arm"), "0,0,0.1");
  EXPECT_TRUE(figures.at("gsd_m").is_null());
  EXPECT_EQ(figures.at("pixel_in_units"), 0.5);
  EXPECT_EQ(figures.at("other_parts").dump(), R"([["a.jpg","b.jpg"]])");
  EXPECT_EQ(figures.at("position_shift_m").size(), 3u);
  EXPECT_EQ(figures.at("instruments").at("position_shift"), "none");
  EXPECT_EQ(figures.at("calibration"), "none");
  record.metric = true;
  EXPECT_EQ(figures_of(record, two_images()).at("gsd_m"), 0.5);
}

TEST(StepFigures, OfAnAdjustmentAreNullWhereNothingIsKnown) {
  AdjustmentRecord record{.images = 2, .sigma0 = std::numeric_limits<double>::quiet_NaN()};
  record.check_rmse_m = {0.25, std::nullopt, 1.0};
  record.control.emplace_back();
  const auto figures = figures_of(record, two_images());
  EXPECT_TRUE(figures.at("sigma0").is_null());
  EXPECT_TRUE(figures.at("control_rmse_m").is_null());
  EXPECT_EQ(figures.at("check_rmse_m").dump(), "[0.25,null,1.0]");
  EXPECT_EQ(figures.at("calibration"), "none");
  EXPECT_EQ(figures.at("sigma_factors").size(), kObservationGroups);
  EXPECT_FALSE(figures.contains("control"));  // shown by name in a table of its own
}

TEST(StepFigures, OfAProductThatWasNotMadeSayWhy) {
  const auto none =
      figures_of(SurfaceRecord{.skipped_because = finding_of(FindingCode::kNoScale, {Product::kSurfaceModel})}, {});
  EXPECT_EQ(none.size(), 1u);
  EXPECT_EQ(none.at("skipped_because").at("code"), "no_scale");
  const Finding unreadable = finding_of(FindingCode::kImageUnreadable, {Subject::file("x.jpg")}, {}, {}, "is no image");
  const auto detect = figures_of(DetectRecord{.images = 2, .features = 7, .skipped = {unreadable}}, {});
  EXPECT_EQ(detect.at("images"), 2);
  EXPECT_EQ(detect.at("features"), 7);
  EXPECT_EQ(detect.at("skipped").at(0).at("code"), "image_unreadable");
  EXPECT_EQ(detect.at("skipped").at(0).at("subjects").at(0).at("name"), "x.jpg");
  EXPECT_EQ(detect.at("skipped").at(0).at("what"), "Image x.jpg is skipped: is no image.");
}

}  // namespace
}  // namespace collinea
