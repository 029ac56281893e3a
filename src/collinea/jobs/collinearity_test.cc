// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/collinearity.h"

#include <gtest/gtest.h>

#include <cmath>

#include "collinea/base/file.h"
#include "collinea/base/test_folder.h"
#include "collinea/geodesy/geodetic_collinearity.h"
#include "collinea/geodesy/test_geoid.h"
#include "collinea/io/text.h"

namespace collinea {
namespace {

class GeodeticImages : public ::testing::Test {
 protected:
  GeodeticImages() { options_.principal_distance_mm = 150; }
  [[nodiscard]] std::filesystem::path file(const std::string& name, const std::string& text) const {
    EXPECT_TRUE(write_file(folder_ / name, text));
    return folder_ / name;
  }
  CollinearityOptions options_;
  TestFolder folder_;
};

constexpr const char* kImage =
    "image latitude[deg] longitude[deg] h[m] omega[deg] phi[deg] kappa[deg]\nA 48.2 15.6 3300 0 0 0\n";

// Below the centre a vertical photograph sees the middle; h and H + N are one height.
TEST_F(GeodeticImages, HeightsAboveTheGeoidAreThoseAboveTheEllipsoid) {
  write_test_geoid(folder_ / "geoid.gtx");
  const double undulation = test_geoid_m(48.21, 15.61);
  const auto ellipsoidal = file("e.txt", "point latitude[deg] longitude[deg] h[m]\n1 48.2 15.6 300\n2 48.21 15.61 " +
                                             exact(250 + undulation) + "\n");
  const auto by_column =
      file("n.txt", "point latitude[deg] longitude[deg] H[m] N[m]\n1 48.2 15.6 300 0\n2 48.21 15.61 250 " +
                        exact(undulation) + "\n");
  const auto by_grid = file("g.txt", "point latitude[deg] longitude[deg] H[m]\n2 48.21 15.61 250\n");
  const auto images = file("i.txt", kImage);
  const auto first = collinearity_of_tables(ellipsoidal, images, options_);
  ASSERT_TRUE(first) << first.error().message;
  EXPECT_LT(first->rows[0].xy.norm(), 1e-9);
  EXPECT_NEAR(first->rows[0].distance_m, 3000, 1e-6);
  EXPECT_GT(first->rows[1].xy.y(), 40);  // 1.1 km to the north
  const auto second = collinearity_of_tables(by_column, images, options_);
  ASSERT_TRUE(second) << second.error().message;
  EXPECT_LT((second->rows[1].xy - first->rows[1].xy).norm(), 1e-10);
  EXPECT_FALSE(collinearity_of_tables(by_grid, images, options_));  // H without geoid
  options_.heights = (folder_ / "geoid.gtx").string();
  const auto third = collinearity_of_tables(by_grid, images, options_);
  ASSERT_TRUE(third) << third.error().message;
  EXPECT_LT((third->rows[0].xy - first->rows[1].xy).norm(), 1e-5);  // the grid holds 0.1 mm
}

// Standard deviations are those of the derivatives, each against a difference of whole runs.
TEST_F(GeodeticImages, SigmasFollowTheDifferences) {
  const auto run = [&](double sigma_plan, double sigma_h, double sigma_kappa, double kappa) {
    return collinearity_of_tables(
               file("p.txt", "point latitude[deg] longitude[deg] h[m] sigma_plan[m] sigma_h[m]\n1 48.205 15.61 320 " +
                                 exact(sigma_plan) + " " + exact(sigma_h) + "\n"),
               file("i.txt",
                    "image latitude[deg] longitude[deg] h[m] omega[deg] phi[deg] kappa[deg] sigma_kappa[deg]\nA 48.2 "
                    "15.6 3300 1 -2 " +
                        exact(kappa) + " " + exact(sigma_kappa) + "\n"),
               options_)
        ->rows[0];
  };
  const auto plan = run(0.5, 0, 0, 30);
  // 0.5 m on the ground at a scale of 150 mm to 2980 m; convergence and tilt change it by some per cent.
  EXPECT_NEAR(plan.sigma.x(), 0.5 * 150 / 2980, 0.05 * 0.5 * 150 / 2980);
  const auto before = run(0, 0, 0.01, 30 - 0.01), after = run(0, 0, 0.01, 30 + 0.01);
  EXPECT_LT((run(0, 0, 0.01, 30).sigma - (after.xy - before.xy).cwiseAbs() / 2).norm(), 1e-7);
  // A height is a derivative, too: that of the tables.
  const auto high = run(0, 1, 0, 30);
  EXPECT_LT((high.sigma - high.by.col(8).cwiseAbs()).norm(), 1e-12);
  EXPECT_NEAR(high.sigma.norm(), high.xy.norm() / 2980, 0.3 * high.xy.norm() / 2980);  // x / (height of flight)
}

TEST_F(GeodeticImages, RefractionIsAddedWithItsSigma) {
  const auto points = file("p.txt", "point latitude[deg] longitude[deg] h[m]\n1 48.21 15.6 300\n2 48.2 15.6 4000\n");
  const auto images = file("i.txt", kImage);
  options_.refraction = RefractionBy::kCoefficient;
  options_.sigma_height_m = 20;
  const auto report = collinearity_of_tables(points, images, options_);
  ASSERT_TRUE(report) << report.error().message;
  ASSERT_EQ(report->rows.size(), 1u);  // the second one is above the camera
  EXPECT_EQ(report->behind.size(), 1u);
  const RadialRefraction expected = refraction_by_coefficient(report->rows[0].xy.norm(), 150, 3000, 0, 20);
  EXPECT_NEAR(report->rows[0].refraction.shift.norm(), expected.shift, 1e-12);
  EXPECT_NEAR(report->rows[0].refraction.sigma.norm(), expected.sigma, 1e-9);
  EXPECT_NE(collinearity_text(*report).find("point 2 lies behind image A"), std::string::npos);
  for (const NamedTable& table : collinearity_tables(*report))
    EXPECT_TRUE(parse_text_table(text_of(table.table))) << table.name;
}

// Mussio D.8: K = 0.13, c = 150 mm, h = 3 km: 1.6985, 4.4162, 9.1722 um at 50, 100, 150 mm.
TEST_F(GeodeticImages, MeasuredPointsAreCorrected) {
  RefractionOptions options;
  options.photo.principal_distance = 150;
  options.refraction = RefractionBy::kCoefficient;
  options.camera_height_m = 3000;
  const auto points = file("m.txt", "point x[mm] y[mm]\n1 50 0\n2 0 -100\n3 90 120\n4 0 0\n");
  const auto report = refraction_of_table(points, options);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_NEAR(report->rows[0].by_coefficient.shift.x(), 1.6985e-3, 6e-8);
  EXPECT_NEAR(report->rows[1].by_coefficient.shift.y(), -4.4162e-3, 6e-8);
  EXPECT_NEAR(report->rows[2].by_coefficient.shift.norm(), 9.1722e-3, 6e-8);
  EXPECT_NEAR(report->rows[1].corrected.y(), -100 + 4.4162e-3, 6e-8);
  EXPECT_TRUE(report->rows[3].by_atmosphere.shift.isZero(0));
  EXPECT_GT(report->rows[0].by_atmosphere.shift.x(), 0);
  // In pixels y points down: the same image.
  options.photo.principal_distance = 15000;
  options.photo.principal_point = "10000,10000";
  const auto in_px = refraction_of_table(file("p.txt", "point x[px] y[px]\n2 10000 20000\n"), options);
  ASSERT_TRUE(in_px);
  EXPECT_NEAR(in_px->rows[0].by_coefficient.shift.y(), 0.44162, 6e-6);
  EXPECT_NE(refraction_text(*report).find("4.4162"), std::string::npos) << refraction_text(*report);
}

TEST_F(GeodeticImages, BadTablesAreRefused) {
  const auto images = file("i.txt", kImage),
             points = file("p.txt", "point latitude[deg] longitude[deg] h[m]\n1 48 15 0\n");
  EXPECT_FALSE(collinearity_of_tables(images, points, options_));
  EXPECT_FALSE(collinearity_of_tables(file("q.txt", "point latitude longitude h\n1 95 15 0\n"), images, options_));
  EXPECT_FALSE(collinearity_of_tables(file("q.txt", "point latitude longitude h H\n1 45 15 0 0\n"), images, options_));
  options_.principal_distance_mm.reset();
  EXPECT_FALSE(collinearity_of_tables(points, images, options_));
  RefractionOptions options;
  options.photo.principal_distance = 150;
  const auto measured = file("m.txt", "point x[mm] y[mm]\n1 50 0\n");
  EXPECT_FALSE(refraction_of_table(measured, options));  // no height
  options.camera_height_m = 1000;
  options.attitude = "0,0";
  EXPECT_FALSE(refraction_of_table(measured, options));
}

}  // namespace
}  // namespace collinea
