// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/internal/noise.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "collinea/math/random.h"

namespace collinea {
namespace {

// Squared lengths of errors in two dimensions, Gaussian or Student's with nu degrees of freedom (even), scale 0.2 px.
std::vector<double> squared_errors(int nu, int count = 5000) {
  Random random(11);
  std::vector<double> squares;
  for (int i = 0; i < count; ++i) {
    double variance = 0.2 * 0.2;
    if (nu > 0) {
      double chi2 = 0;
      for (int k = 0; k < nu; ++k) chi2 += std::pow(random.normal(), 2);
      variance *= nu / chi2;
    }
    squares.push_back(variance * (std::pow(random.normal(), 2) + std::pow(random.normal(), 2)));
  }
  return squares;
}

double degrees_of_freedom(const TieNoise& noise) { return std::pow(noise.loss_scale_sigmas, 2) - 2; }

double scale_px(const TieNoise& noise) {
  const double nu = degrees_of_freedom(noise);
  return noise.sigma_px * std::sqrt((nu + 2) / nu);
}

TEST(Noise, ScaleAndShapeOfAStudentDistributionAreFound) {
  for (const int nu : {2, 4, 10}) {
    const auto noise = fit_noise(squared_errors(nu));
    ASSERT_TRUE(noise);
    EXPECT_EQ(noise->loss, Loss::kCauchy);
    EXPECT_NEAR(degrees_of_freedom(*noise), nu, 1e-9);
    EXPECT_NEAR(scale_px(*noise), 0.2, 4 * 0.2 / std::sqrt(5000.0)) << nu;  // its deviation is about scale / sqrt(n)
  }
}

TEST(Noise, OneErrorOfAThousandIsGross) {
  for (const int nu : {2, 4, 10}) {
    constexpr int kCount = 100000;
    const std::vector<double> squares = squared_errors(nu, kCount);
    const auto noise = fit_noise(squares);
    ASSERT_TRUE(noise);
    const double gross_px2 = std::pow(noise->gross_sigmas * noise->sigma_px, 2);
    const auto gross = std::count_if(squares.begin(), squares.end(), [&](double square) { return square > gross_px2; });
    EXPECT_NEAR(static_cast<double>(gross), 0.001 * kCount, 4 * std::sqrt(0.001 * kCount)) << nu;
  }
}

TEST(Noise, GaussianErrorsHardlyBendTheLoss) {
  const auto noise = fit_noise(squared_errors(0));
  ASSERT_TRUE(noise);
  EXPECT_NEAR(degrees_of_freedom(*noise), 20, 1e-9);
  EXPECT_NEAR(noise->sigma_px, 0.2, 0.02);
}

TEST(Noise, ATenthOfGrossErrorsHardlyChangesTheScale) {
  std::vector<double> squares = squared_errors(4);
  for (std::size_t i = 0; i < squares.size(); i += 10) squares[i] = 100;
  const auto noise = fit_noise(squares);
  ASSERT_TRUE(noise);
  EXPECT_NEAR(degrees_of_freedom(*noise), 2, 1e-9);
  EXPECT_NEAR(scale_px(*noise), 0.2, 0.04);
}

TEST(Noise, TooFewErrorsOrNoneAtAllGiveNothing) {
  EXPECT_FALSE(fit_noise(squared_errors(4, 99)));
  EXPECT_FALSE(fit_noise(std::vector<double>(1000, 0.0)));
}

TEST(Noise, LargeFeaturesAreLessPreciseInProportionToTheirScale) {
  EXPECT_DOUBLE_EQ(sigma_factor(2), 1);
  EXPECT_NEAR(sigma_factor(0), std::sqrt(0.5), 1e-12);
  EXPECT_NEAR(sigma_factor(200) / sigma_factor(100), 2, 1e-3);
}

}  // namespace
}  // namespace collinea
