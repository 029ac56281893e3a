// SPDX-License-Identifier: Apache-2.0
// Orientations of a pair that are given: converted, and compared with points.
#include <gtest/gtest.h>

#include <cmath>

#include "collinea/base/file.h"
#include "collinea/base/test_folder.h"
#include "collinea/io/text.h"
#include "collinea/jobs/internal/codes_for_tests.h"
#include "collinea/jobs/relative.h"
#include "collinea/math/random.h"

namespace collinea {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
constexpr double kDegrees = 180 / M_PI;

class GivenRelative : public ::testing::Test {
 protected:
  GivenRelative() { options_.photo.principal_distance = 153; }
  [[nodiscard]] std::filesystem::path file(const std::string& name, const std::string& text) const {
    EXPECT_TRUE(write_file(folder_ / name, text));
    return folder_ / name;
  }
  // 24 points of relief with noise of 5 um, which the table states.
  [[nodiscard]] std::filesystem::path points() const {
    Random random(1);
    const Rigid3 motion = motion_of(truth_);
    std::string text = "point x_left[mm] y_left[mm] x_right[mm] y_right[mm] sigma[mm]\n";
    for (int i = 0; i < 24; ++i) {
      const Vector3d x(random.uniform(-0.2, 1.2), random.uniform(-1, 1), random.uniform(1.4, 1.8));
      const Vector2d one = x.hnormalized(), two = (motion * x).hnormalized();
      text += "P" + std::to_string(i);
      for (const double v : {one.x(), -one.y(), two.x(), -two.y()})
        text += " " + exact(153 * v + 0.005 * random.normal());
      text += " 0.005\n";
    }
    return file("pair.txt", text);
  }
  [[nodiscard]] std::string typed(const DependentElements& e) const {
    std::string text = "dependent:" + exact(e.by) + "," + exact(e.bz);
    for (const double angle : {e.omega, e.phi, e.kappa}) text += "," + exact(angle * kDegrees);
    return text;
  }
  // Elements and covariances of a report, in both forms.
  static void expect_alike(const RelativeReport& a, const RelativeReport& b, double in_sigmas, double of_covariance) {
    const Rigid3 &one = a.orientation.second_from_first, &two = b.orientation.second_from_first;
    const Matrix5 first = a.orientation.stated_covariance(), second = b.orientation.stated_covariance();
    const Vector5 sigmas = first.diagonal().cwiseSqrt();
    const Vector5 off = symmetric_elements(one).values() - symmetric_elements(two).values();
    EXPECT_LT((off.cwiseAbs().array() / sigmas.array()).maxCoeff(), in_sigmas);
    for (int i = 0; i < 5; ++i)
      for (int k = 0; k < 5; ++k)
        EXPECT_NEAR(first(i, k), second(i, k), of_covariance * sigmas(i) * sigmas(k)) << i << " " << k;
  }

  DependentElements truth_{1, 0.03, -0.02, 0.011, -0.013, 0.02};
  RelativePairOptions options_;
  TestFolder folder_;
};

// What a solution writes is read again: values with eight decimals and nine digits, correlations with so many that the
// covariance is right to a thousandth. The covariance of an exterior orientation has rank 5, its base no error.
TEST_F(GivenRelative, TheTablesOfASolutionGiveItBack) {
  options_.out = folder_ / "out";
  const auto solved = orient_pair(points(), options_);
  ASSERT_TRUE(solved) << solved.error().message;
  RelativePairOptions given;
  given.given = (folder_ / "out" / "exterior.txt").string();
  const auto of_exterior = orient_pair({}, given);
  ASSERT_TRUE(of_exterior) << of_exterior.error().message;
  EXPECT_EQ(of_exterior->given_form, RelativeForm::kExterior);
  expect_alike(*solved, *of_exterior, 0.01, 0.01);
  EXPECT_LT((solved->right_pose - of_exterior->right_pose).norm(), 1e-6);
  given.given = (folder_ / "out" / "parameters.txt").string();
  given.given_correlations = folder_ / "out" / "correlations.txt";
  const auto of_elements = orient_pair({}, given);
  ASSERT_TRUE(of_elements) << of_elements.error().message;
  EXPECT_EQ(of_elements->given_form, RelativeForm::kDependent);
  expect_alike(*solved, *of_elements, 1e-3, 1e-3);
  EXPECT_LT((solved->right_covariance - of_elements->right_covariance).norm(), 1e-3 * solved->right_covariance.norm());
  // The symmetric form alone is as good.
  std::string table = read_file(folder_ / "out" / "parameters.txt").value(), symmetric;
  for (const std::string_view line : lines_of(table))
    if (!line.starts_with("dependent")) symmetric += std::string(line) + "\n";
  given.given = file("symmetric.txt", symmetric).string();
  const auto of_symmetric = orient_pair({}, given);
  ASSERT_TRUE(of_symmetric) << of_symmetric.error().message;
  EXPECT_EQ(of_symmetric->given_form, RelativeForm::kSymmetric);
  expect_alike(*solved, *of_symmetric, 1e-3, 1e-3);
}

TEST_F(GivenRelative, TypedElementsAreConvertedWithTheirSigmas) {
  options_.given = typed(truth_) + ",0.001,0.001,0.01,0.01,0.01";
  options_.base_m = 600;
  options_.out = folder_ / "out";
  const auto given = orient_pair({}, options_);
  ASSERT_TRUE(given) << given.error().message;
  EXPECT_LT((dependent_elements(given->orientation.second_from_first)->values() - truth_.values()).norm(), 1e-12);
  EXPECT_NEAR(given->right_pose(0), 600 / std::sqrt(1 + 0.0009 + 0.0004), 1e-9);
  EXPECT_NEAR(given->right_pose(5), 0.02 * kDegrees, 1e-9);
  EXPECT_NEAR(std::sqrt(given->right_covariance(5, 5)), 0.01, 1e-9);
  // Y = base by / |b|, |b| = sqrt(1 + by^2 + bz^2): its sigma is that of by, less what |b| takes.
  EXPECT_NEAR(std::sqrt(given->right_covariance(1, 1)), 0.6, 0.6 * 0.003);
  const std::string text = relative_text(*given);
  for (const char* words : {"as given, dependent", "symmetric pair", "exterior orientation of the right image"})
    EXPECT_NE(text.find(words), std::string::npos) << text;
  for (const char* name : {"parameters.txt", "correlations.txt", "exterior.txt"})
    EXPECT_TRUE(read_text_table(folder_ / "out" / name)) << name;
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out" / "coplanarity.txt"));
}

// True elements fit the points; elements that are off do not, unless their sigmas say so.
TEST_F(GivenRelative, NothingOfPointsStaysBesideAnOrientationWithout) {
  options_.given = typed(truth_);
  options_.out = folder_ / "out";
  ASSERT_TRUE(orient_pair(points(), options_));
  ASSERT_TRUE(write_file(folder_ / "out" / "fundamental.txt", "of a pair in pixels"));
  ASSERT_TRUE(is_there(folder_ / "out" / "coplanarity.txt") && is_there(folder_ / "out" / "findings.json"));
  ASSERT_TRUE(orient_pair({}, options_));
  for (const char* name : {"fundamental.txt", "coplanarity.txt", "findings.json"})
    EXPECT_FALSE(is_there(folder_ / "out" / name)) << name;
}

TEST_F(GivenRelative, PointsAreComparedWithoutASolution) {
  options_.given = typed(truth_);
  options_.out = folder_ / "out";
  const auto right = orient_pair(points(), options_);
  ASSERT_TRUE(right) << right.error().message;
  EXPECT_EQ(codes_of(right->findings), Codes{});
  EXPECT_EQ(right->orientation.in_front, 24);
  // 24 conditions: sigma0 within four of its standard deviations of 1.
  EXPECT_NEAR(right->coplanarity->sigma0, 1, 4 / std::sqrt(2 * 24.0));
  const auto table = read_text_table(folder_ / "out" / "coplanarity.txt");
  ASSERT_TRUE(table);
  const auto dependent = table->numbers("dependent", ""), symmetric = table->numbers("symmetric", ""),
             gap = table->numbers("gap", "mm");
  ASSERT_TRUE(dependent && symmetric && gap);
  for (std::size_t i = 0; i < 24; ++i) {
    EXPECT_NEAR((*dependent)[i], (*symmetric)[i] * std::sqrt(1 + 0.0009 + 0.0004), 1e-7 * std::abs((*symmetric)[i]));
    EXPECT_LT(std::abs((*gap)[i]), 6 * 0.005);
  }
  DependentElements off = truth_;
  off.kappa += 0.002;
  options_.given = typed(off);
  const auto wrong = orient_pair(points(), options_);
  ASSERT_TRUE(wrong);
  EXPECT_EQ(codes_of(wrong->findings), (Codes{"measurement_contradicts", "residuals_large"}));
  options_.given = typed(off) + ",0.001,0.001,0.2,0.2,0.2";
  const auto loose = orient_pair(points(), options_);
  ASSERT_TRUE(loose);
  EXPECT_EQ(codes_of(loose->findings), Codes{});
}

TEST_F(GivenRelative, WhatIsNoOrientationIsRefused) {
  const auto refused = [&](const std::string& given) {
    options_.given = given;
    return !orient_pair({}, options_);
  };
  EXPECT_FALSE(orient_pair({}, options_));  // no points and nothing given
  for (const char* given : {"dependent:1,2,3,4", "dependent:a,2,3,4,5", "dependent:0,0,0,0,0,-1,1,1,1,1",
                            "dependent:0,0,0,90,0", "symmetric:90,0,0,0,0", "no_such_file.txt"})
    EXPECT_TRUE(refused(given)) << given;
  EXPECT_TRUE(refused(file("one.txt", "image X[m] Y[m] Z[m] omega phi kappa\nA 0 0 0 0 0 0\n").string()));
  EXPECT_TRUE(
      refused(file("same.txt", "image X[m] Y[m] Z[m] omega phi kappa\nA 0 0 0 0 0 0\nB 0 0 0 1 0 0\n").string()));
  EXPECT_TRUE(refused(file("few.txt", "form element value sigma\ndependent by 0 0\n").string()));
  EXPECT_FALSE(
      refused(file("two.txt", "image X[m] Y[m] Z[m] omega phi kappa\nA 0 0 0 0 0 0\nB 9 0 0 1 0 0\n").string()));
  options_.base_m = 100;
  EXPECT_TRUE(refused((folder_ / "two.txt").string()));
}

// The exhaustive start is stated in text and table, with the orientations that fit as well.
TEST_F(GivenRelative, TheSearchIsWritten) {
  options_.adjustment.start = PairStart::kGrid;
  options_.out = folder_ / "out";
  const auto report = orient_pair(points(), options_);
  ASSERT_TRUE(report) << report.error().message;
  ASSERT_TRUE(report->orientation.search);
  const auto table = read_text_table(folder_ / "out" / "search.txt");
  ASSERT_TRUE(table);
  const auto solutions = table->words("solution"), names = table->words("element");
  const auto values = table->numbers("value", "");
  ASSERT_TRUE(solutions && names && values);
  EXPECT_EQ((*names)[0], "starts");
  EXPECT_EQ((*values)[0], 5408);
  EXPECT_EQ((*names)[1], "converged");
  EXPECT_EQ((*values)[1], report->orientation.search->converged);
  EXPECT_EQ((*values)[2], 4);  // the four motions with the same coplanarity
  // One of them is what least squares began at: within some of its standard deviations of 1e-4.
  bool is_there = false;
  for (std::size_t row = 0; row < names->size(); ++row)
    is_there |= (*names)[row] == "kappa" && std::abs((*values)[row] - truth_.kappa * kDegrees) < 0.05;
  EXPECT_TRUE(is_there);
  EXPECT_EQ(solutions->back(), "4");
  options_.adjustment.start = PairStart::kLinear;
  options_.out = folder_ / "linear";
  ASSERT_TRUE(orient_pair(points(), options_));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "linear" / "search.txt"));
}

}  // namespace
}  // namespace collinea
