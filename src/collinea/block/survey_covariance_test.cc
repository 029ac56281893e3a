// SPDX-License-Identifier: Apache-2.0
#include "collinea/block/survey_covariance.h"

#include <gtest/gtest.h>

#include <limits>

namespace collinea {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(SurveyCovariance, WeightIsItsInverseAndCorrelationsComeBack) {
  const Eigen::Vector3d sigma(0.01, 0.03, 0.5), correlation(0.9, -0.4, -0.5);
  const Eigen::Matrix3d covariance = survey_covariance(sigma, correlation);
  EXPECT_NEAR(covariance(0, 1), 0.9 * 0.01 * 0.03, 1e-18);
  EXPECT_NEAR(covariance(2, 1), -0.5 * 0.5 * 0.03, 1e-18);
  const auto weight = survey_weight(sigma, correlation);
  ASSERT_TRUE(weight);
  EXPECT_LT((*weight * covariance - Eigen::Matrix3d::Identity()).norm(), 1e-12);
  EXPECT_LT((correlation_of(covariance) - correlation).norm(), 1e-15);
}

TEST(SurveyCovariance, AxesThatWereNotSurveyedStayOut) {
  const Eigen::Vector3d sigma(0.01, 0.03, kInfinity), correlation(0.8, 7, 7);
  const auto weight = survey_weight(sigma, correlation);
  ASSERT_TRUE(weight);
  EXPECT_TRUE(weight->row(2).isZero(0) && weight->col(2).isZero(0));
  EXPECT_NEAR((*weight)(0, 0), 1e4 / (1 - 0.64), 1e-8);
  EXPECT_TRUE(survey_covariance(sigma, correlation).row(2).isZero(0));
  EXPECT_TRUE(survey_weight(Eigen::Vector3d::Constant(kInfinity), correlation)->isZero(0));
}

TEST(SurveyCovariance, WhatIsNoCovarianceIsRefused) {
  const Eigen::Vector3d sigma(0.01, 0.03, 0.5);
  EXPECT_FALSE(survey_weight(sigma, {1, 0, 0}));
  EXPECT_FALSE(survey_weight(sigma, {0.9, 0.9, -0.9}));
  EXPECT_FALSE(survey_weight(sigma, {std::numeric_limits<double>::quiet_NaN(), 0, 0}));
  EXPECT_TRUE(survey_weight(sigma, {0.9, 0.9, 0.9}));
}

}  // namespace
}  // namespace collinea
