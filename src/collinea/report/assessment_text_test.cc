// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/assessment_text.h"

#include <gtest/gtest.h>

namespace collinea {
namespace {

HeightErrors heights(std::size_t cells) {
  return {.cells = cells, .mean_m = -0.01, .rmse_m = 0.2, .median_m = 0, .nmad_m = 0.1, .share_gross = 0.005};
}

SurfaceErrors surface() {
  SurfaceErrors errors;
  errors.cell_m = 0.1;
  errors.overall = heights(1000);
  errors.smooth_ground = heights(800);
  return errors;
}

TEST(AssessmentText, NamesWhatIsThere) {
  Assessment assessment;
  EXPECT_EQ(assessment_text(assessment), "images oriented                    0 of 0\n");
  assessment.surface = SurfaceErrors{};
  assessment.surface->cell_m = 0.1;
  EXPECT_EQ(assessment_text(assessment).find("relative sigma"), std::string::npos);
  assessment.relative_within_bounds = 0.0;
  EXPECT_NE(assessment_text(assessment).find("less the plane of all errors, within 95 % bounds 0.0 %"),
            std::string::npos);
  EXPECT_EQ(assessment_text(assessment).find("orthophoto"), std::string::npos);
  assessment.ortho = OrthoErrors{};
  EXPECT_NE(assessment_text(assessment).find("surface model, smooth ground"), std::string::npos);
  EXPECT_NE(assessment_text(assessment).find("orthophoto"), std::string::npos);
}

TEST(AssessmentText, LinesKeepTheirForm) {
  Assessment assessment;
  assessment.poses = {.images = 40, .oriented = 39, .rotation_rms_deg = 0.00123};
  assessment.check_points = PointErrors{4, {0.01, 0.02, 0.03}, {0.001, -0.002, 0}, 0.0374, 0.05};
  assessment.surface = surface();
  assessment.terrain = TerrainErrors{.cell_m = 0.1, .overall = heights(500), .object_cells = 70, .share_removed = 0.9};
  EXPECT_EQ(
      assessment_text(assessment),
      "images oriented                    39 of 40\n"
      "check points                           4   RMS east 0.0100  north 0.0200  up 0.0300  3D 0.0374 m   worst 0.0500 "
      "m   mean +0.0010 -0.0020 +0.0000\n"
      "surface model, all                      1000 cells   RMSE 0.2000 m = 2.00 GSD   NMAD 0.1000 m = 1.00 GSD   mean "
      "-0.0100 m   gross 0.50 %\n"
      "surface model, smooth ground             800 cells   RMSE 0.2000 m = 2.00 GSD   NMAD 0.1000 m = 1.00 GSD   mean "
      "-0.0100 m   gross 0.50 %\n"
      "surface model, completeness        0.00 %   measured 0.00 %   where 3 or more images see 0.00 %   cell 0.1 m\n"
      "terrain model, all                       500 cells   RMSE 0.2000 m = 2.00 GSD   NMAD 0.1000 m = 1.00 GSD   mean "
      "-0.0100 m   gross 0.50 %\n"
      "terrain model, objects removed     90.00 % of 70 cells\n");
}

TEST(AssessmentText, WithTheSizeOfAPixelErrorsAreTimesThat) {
  Assessment assessment;
  assessment.surface = surface();
  assessment.walls = WallErrors{.samples = 12, .rms_m = 0.1, .median_m = 0.05, .mean_m = 0.02, .share_within = 0.75};
  assessment.gsd_m = 0.05;
  const std::string text = assessment_text(assessment);
  EXPECT_NE(text.find("RMSE 0.2000 m = 4.00 GSD"), std::string::npos) << text;
  EXPECT_NE(
      text.find("surface model, walls               12 samples   RMS 0.1000 m = 2.00 GSD   median 1.00 GSD   mean "
                "+0.0200 m   within 2 GSD 75.0 %\n"),
      std::string::npos)
      << text;
}

TEST(AssessmentText, OnlyWellFilledClassesOfTheCloudAreListed) {
  Assessment assessment;
  assessment.cloud = CloudErrors{1000, 0.95, 0.002, {{2, 700, 1.04}, {3, 299, 0.5}}};
  EXPECT_NE(
      assessment_text(assessment)
          .find("cloud, sigma                       1000 points   within 95 % bounds 95.0 %   beyond 5 sigmas 0.20 %   "
                "RMS of others in sigmas, by images: 2: 1.04\n"),
      std::string::npos);
}

}  // namespace
}  // namespace collinea
