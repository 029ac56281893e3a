// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/factorise.h"

#include <gtest/gtest.h>

#include <cmath>

#include "collinea/base/file.h"
#include "collinea/base/test_folder.h"
#include "collinea/epipolar/survey_for_tests.h"
#include "collinea/io/text.h"

namespace collinea {
namespace {

class Factorise : public ::testing::Test {
 protected:
  [[nodiscard]] std::filesystem::path file(const std::string& text) const {
    EXPECT_TRUE(write_file(folder_ / "m.txt", text));
    return folder_ / "m.txt";
  }
  // As a table in px, or in mm of pixels of 5 um with y up about the middle of a sensor of 3000 x 2000.
  static std::string table_of(const SelfCalibrationTruth& truth, bool in_mm = false) {
    std::string text = in_mm ? "image point x[mm] y[mm]\n" : "image point x[px] y[px]\n";
    for (std::size_t i = 0; i < truth.measured.images(); ++i)
      for (Eigen::Index p = 0; p < truth.measured.points(); ++p) {
        const double x = truth.measured.xy[i](0, p), y = truth.measured.xy[i](1, p);
        text += "I" + std::to_string(i) + " " + std::to_string(p) + " " + exact(in_mm ? 0.005 * (x - 1500) : x) + " " +
                exact(in_mm ? -0.005 * (y - 1000) : y) + "\n";
      }
    return text;
  }
  static double value(const std::vector<Estimate>& estimates, const std::string& name) {
    for (const Estimate& e : estimates)
      if (e.name == name) return e.value;
    return NAN;
  }
  TestFolder folder_;
};

TEST_F(Factorise, PixelsAndMillimetresGiveOneCamera) {
  const SelfCalibrationTruth truth = self_calibration_truth({.images = 5, .points = 30, .seed = 2});
  FactoriseOptions options;
  options.calibration = CalibrationUnknowns::kAll;
  const auto in_px = factorise_table(file(table_of(truth)), options),
             in_mm = factorise_table(file(table_of(truth, true)), options);
  ASSERT_TRUE(in_px) << in_px.error().message;
  ASSERT_TRUE(in_mm) << in_mm.error().message;
  ASSERT_TRUE(in_px->self_calibrated && in_mm->self_calibrated) << in_px->why_not_euclidean << in_mm->why_not_euclidean;
  const auto &px = in_px->self_calibrated->interior, &mm = in_mm->self_calibrated->interior;
  EXPECT_NEAR(value(px, "c_x"), 3000, 1e-3);
  EXPECT_NEAR(value(px, "c_y"), 2950, 1e-3);
  EXPECT_NEAR(value(px, "axes"), 90, 1e-5);
  EXPECT_NEAR(value(px, "y0"), 990, 1e-3);
  EXPECT_NEAR(value(mm, "c_x"), 15, 1e-5);
  EXPECT_NEAR(value(mm, "x0"), 0.05, 1e-5);
  EXPECT_NEAR(value(mm, "y0"), 0.05, 1e-5);
  ASSERT_FALSE(in_px->from_fundamentals.empty());
  EXPECT_NEAR(value(in_px->from_fundamentals, "c_x"), 3000, 0.1);
  EXPECT_EQ(in_px->unit_base, in_mm->unit_base);
  // One camera of both stands at the unit of length, and all cameras agree.
  const auto centre = [](const FactorisationReport& report, std::size_t i) {
    const auto& e = report.self_calibrated->exterior[i];
    return Eigen::Vector3d(value(e, "X"), value(e, "Y"), value(e, "Z"));
  };
  EXPECT_NEAR(centre(*in_px, in_px->unit_base).norm(), 1, 1e-9);
  for (std::size_t i = 0; i < 5; ++i) EXPECT_LT((centre(*in_px, i) - centre(*in_mm, i)).norm(), 1e-5);
  // Projective cameras and points of the tables give the measurements.
  const Eigen::Vector3d seen = in_mm->projective.matrices[3] * in_mm->projective.points.col(7);
  EXPECT_NEAR(seen.y() / seen.z(), -0.005 * (truth.measured.xy[3](1, 7) - 1000), 1e-6);
}

// The stated camera is square, the true one is not: the calibrated path is refuted, the self-calibrated one is not.
TEST_F(Factorise, TheCalibratedPathStandsBeside) {
  SelfCalibrationTruth truth = self_calibration_truth({.images = 5, .points = 30, .sigma = 0.3, .seed = 4});
  FactoriseOptions options;
  options.sigma = 0.3;
  options.calibration = CalibrationUnknowns::kAll;
  options.photo.principal_distance = 3000;
  options.photo.principal_point = "1510,990";
  const auto wrong = factorise_table(file(table_of(truth)), options);
  ASSERT_TRUE(wrong && wrong->calibrated && wrong->self_calibrated);
  EXPECT_GT(wrong->calibrated->variance.sigma0, 2);
  EXPECT_LT(wrong->self_calibrated->variance.sigma0, 1.3);
  const std::string text = factorisation_text(*wrong);
  EXPECT_NE(text.find("self-calibrated one: 5 conditions"), std::string::npos) << text;
  EXPECT_NE(text.find("The stated camera costs more"), std::string::npos) << text;
  // With square pixels both agree within five standard deviations.
  for (Eigen::Matrix2Xd& xy : truth.measured.xy)
    xy.row(1) = ((xy.row(1).array() - 990) * (3000.0 / 2950) + 990).matrix();
  const auto right = factorise_table(file(table_of(truth)), options);
  ASSERT_TRUE(right && right->calibrated && right->self_calibrated);
  EXPECT_LT(right->calibrated->variance.sigma0, 1.3);
  for (const FactorisationReport::Difference& d : right->differences) {
    EXPECT_LE(d.centre, 5 * d.sigma_centre + 1e-12);  // rounding of the first one, which is fixed
    EXPECT_LE(d.rotation_deg, 5 * d.sigma_rotation_deg + 1e-12);
  }
  for (const NamedTable& table : factorisation_tables(*right))
    EXPECT_TRUE(parse_text_table(text_of(table.table))) << table.name;
  EXPECT_EQ(factorisation_tables(*right).size(), 11u);
}

TEST_F(Factorise, PointsWithGrossErrorsAreLeftOut) {
  SelfCalibrationTruth truth = self_calibration_truth({.images = 5, .points = 30, .sigma = 0.3, .seed = 6});
  truth.measured.xy[2].col(11) += Eigen::Vector2d(6, -9);
  truth.measured.xy[4].col(20) += Eigen::Vector2d(-40, 25);
  FactoriseOptions options;
  options.sigma = 0.3;
  options.calibration = CalibrationUnknowns::kAll;
  const auto named = factorise_table(file(table_of(truth)), options);
  ASSERT_TRUE(named && named->self_calibrated);
  EXPECT_NE(factorisation_text(*named).find("contradicts the others: largest"), std::string::npos);
  options.reject = true;
  const auto report = factorise_table(file(table_of(truth)), options);
  ASSERT_TRUE(report && report->self_calibrated);
  EXPECT_EQ(report->rejected, (std::vector<std::string>{"11", "20"}));
  EXPECT_TRUE(report->left_out.empty());
  EXPECT_LT(report->self_calibrated->variance.sigma0, 1.3);
}

TEST_F(Factorise, WhatIsNotDeterminedIsSaid) {
  FactoriseOptions options;
  const auto two = factorise_table(file(table_of(self_calibration_truth({.images = 2, .points = 20}))), options);
  ASSERT_TRUE(two) << two.error().message;
  EXPECT_FALSE(two->self_calibrated);
  EXPECT_NE(factorisation_text(*two).find("no Euclidean form: self-calibration needs three images"), std::string::npos);
  const auto flat = factorise_table(file(table_of(self_calibration_truth({.points = 20, .is_flat = true}))), options);
  ASSERT_FALSE(flat);
  EXPECT_NE(flat.error().message.find("plane"), std::string::npos);
  EXPECT_FALSE(factorise_table(file("image point x[px] y[px]\nA 1 0 0\nB 1 1 1\n"), options));
  EXPECT_FALSE(factorise_table(folder_ / "none", options));
  // Points that an image does not show are left out, and counted.
  std::string text = table_of(self_calibration_truth({.images = 4, .points = 20}));
  text.erase(text.find("I2 5 "), text.find("\nI2 6 ") + 1 - text.find("I2 5 "));
  const auto partly = factorise_table(file(text), options);
  ASSERT_TRUE(partly) << partly.error().message;
  EXPECT_EQ(partly->left_out, std::vector<std::string>{"5"});
  EXPECT_EQ(partly->points.size(), 19u);
}

}  // namespace
}  // namespace collinea
