// SPDX-License-Identifier: Apache-2.0
#include "collinea/restitution/measured_figure.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <numbers>

#include "collinea/math/random.h"

namespace collinea {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

// A roof: four corners of a slanted rectangle of 8 x 5 m, 3 m of rise over 4 m of run, and a point beside it.
FigurePoints roof(double sigma_m = 0.02) {
  FigurePoints points{{{0, 0, 10}, {8, 0, 10}, {8, 4, 13}, {0, 4, 13}, {3, -7, 2}}};
  points.covariance = sigma_m * sigma_m * MatrixXd::Identity(15, 15);
  return points;
}

std::vector<std::size_t> corners_of(FigureKind kind) {
  const FigureSize size = size_of(kind);
  if (size.is_least) return {0, 1, 2, 3};
  return size.count == 3 ? std::vector<std::size_t>{0, 1, 4} : std::vector<std::size_t>{0, 2};
}

TEST(MeasuredFigure, ValuesAreThoseOfGeometry) {
  const FigurePoints points = roof();
  const auto value = [&](FigureKind kind, std::vector<std::size_t> numbers) {
    return measure_figure(kind, numbers, points)->value;
  };
  EXPECT_NEAR(value(FigureKind::kDistance, {0, 2}), std::sqrt(64 + 16 + 9), 1e-12);
  EXPECT_NEAR(value(FigureKind::kPlanDistance, {0, 2}), std::sqrt(80), 1e-12);
  EXPECT_NEAR(value(FigureKind::kHeightDifference, {0, 2}), 3, 1e-12);
  EXPECT_NEAR(value(FigureKind::kHeightDifference, {2, 0}), -3, 1e-12);
  EXPECT_NEAR(value(FigureKind::kSlope, {0, 3}), std::atan2(3, 4), 1e-12);
  EXPECT_NEAR(value(FigureKind::kAngle, {0, 1, 2}), std::numbers::pi / 2, 1e-12);
  EXPECT_NEAR(value(FigureKind::kLength, {0, 1, 2, 3}), 8 + 5 + 8, 1e-12);
  EXPECT_NEAR(value(FigureKind::kArea, {0, 1, 2, 3}), 40, 1e-12);
  EXPECT_NEAR(value(FigureKind::kArea, {3, 2, 1, 0}), 40, 1e-12);  // either way round
  EXPECT_NEAR(value(FigureKind::kPlanArea, {0, 1, 2, 3}), 32, 1e-12);
}

// Independent points: of a distance both ends, each with its own variance along it.
TEST(MeasuredFigure, SigmaOfADistanceIsThatOfItsTwoEnds) {
  const std::vector<std::size_t> ends{0, 1};
  EXPECT_NEAR(measure_figure(FigureKind::kDistance, ends, roof(0.02))->sigma, 0.02 * std::sqrt(2), 1e-15);
  FigurePoints together = roof();
  for (int p = 0; p < 5; ++p)
    for (int q = 0; q < 5; ++q) together.covariance.block<3, 3>(3 * p, 3 * q) = 0.25 * Eigen::Matrix3d::Identity();
  EXPECT_NEAR(measure_figure(FigureKind::kDistance, ends, together)->sigma, 0, 1e-9);  // they move as one
}

// Against figures of points that are moved by errors of a random covariance. Errors of some millimetres at metres:
// second-order terms are a thousandth of them. A standard deviation of 20,000 trials is good to 0.5 %; three of these
// and a little for what is of second order.
TEST(MeasuredFigure, SigmasAreThoseOfMovedPoints) {
  constexpr int kTrials = 20000;
  FigurePoints points = roof();
  Random random(3);
  MatrixXd root(15, 15);
  for (int i = 0; i < 15; ++i)
    for (int k = 0; k < 15; ++k) root(i, k) = 1e-3 * random.normal();
  points.covariance = root * root.transpose();
  for (const auto& kind : kFigureKindWords) {
    const std::vector<std::size_t> numbers = corners_of(kind.value);
    const MeasuredFigure stated = *measure_figure(kind.value, numbers, points);
    double squares = 0;
    for (int trial = 0; trial < kTrials; ++trial) {
      VectorXd noise(15);
      for (int i = 0; i < 15; ++i) noise[i] = random.normal();
      const VectorXd error = root * noise;
      FigurePoints moved = points;
      for (std::size_t p = 0; p < 5; ++p) moved.positions[p] += error.segment<3>(Eigen::Index(3 * p));
      squares += std::pow(measure_figure(kind.value, numbers, moved)->value - stated.value, 2);
    }
    EXPECT_NEAR(std::sqrt(squares / kTrials) / stated.sigma, 1, 0.02) << kind.word;
  }
}

// Heights count from a curved surface where they are given: the level distance of 3 and 4 m of rise is another.
TEST(MeasuredFigure, HeightsAreThoseGiven) {
  FigurePoints points = roof();
  points.heights = {0, 0, 0, 4, 0};
  EXPECT_NEAR(measure_figure(FigureKind::kHeightDifference, std::vector<std::size_t>{0, 3}, points)->value, 4, 1e-12);
  EXPECT_NEAR(measure_figure(FigureKind::kPlanDistance, std::vector<std::size_t>{0, 3}, points)->value, 3, 1e-12);
}

TEST(MeasuredFigure, WhatIsNoFigureIsRefused) {
  FigurePoints points = roof();
  const auto code = [&](FigureKind kind, std::vector<std::size_t> numbers) {
    const auto measured = measure_figure(kind, numbers, points);
    return measured ? std::nullopt : std::optional(measured.error().code);
  };
  EXPECT_EQ(code(FigureKind::kDistance, {0}), Errc::kBadInput);
  EXPECT_EQ(code(FigureKind::kDistance, {0, 1, 2}), Errc::kBadInput);
  EXPECT_EQ(code(FigureKind::kArea, {0, 1}), Errc::kBadInput);
  EXPECT_EQ(code(FigureKind::kDistance, {0, 9}), Errc::kBadInput);
  EXPECT_EQ(code(FigureKind::kDistance, {1, 1}), Errc::kIllPosed);
  EXPECT_EQ(code(FigureKind::kAngle, {0, 1, 1}), Errc::kIllPosed);
  points.positions[4] = {16, 0, 10};  // beyond the second point, in one line with it
  EXPECT_EQ(code(FigureKind::kAngle, {0, 1, 4}), Errc::kIllPosed);
  EXPECT_EQ(code(FigureKind::kArea, {0, 1, 4}), Errc::kIllPosed);
  points.positions[4] = {0, 0, 15};
  EXPECT_EQ(code(FigureKind::kPlanDistance, {0, 4}), Errc::kIllPosed);
}

}  // namespace
}  // namespace collinea
