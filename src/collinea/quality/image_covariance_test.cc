// SPDX-License-Identifier: Apache-2.0
// Image points whose two coordinates have standard deviations of their own and are correlated.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "collinea/quality/internal/test_examine.h"
#include "collinea/quality/systematics.h"
#include "collinea/quality/test_flight.h"

namespace collinea::testing {
namespace {

const Run kRun;
constexpr double kSigma_px = 0.4, kControl_m = 0.01;
constexpr PixelShape kOfMarks{2.5F, 0.7F}, kOfTies{0.5F, -0.6F};

// Gives measurements errors as their covariances say.
void spoil(Block& block, Random& random) {
  const auto spoil_one = [&](auto& seen, const PixelShape& shape) {
    const double a = random.normal(), b = random.normal();
    seen.sigma_px = kSigma_px;
    seen.shape = shape;
    seen.pixel += kSigma_px * shape.whitening().inverse() * Eigen::Vector2d(a, b);
  };
  for (Observation& seen : block.observations) spoil_one(seen, kOfTies);
  for (ControlObservation& seen : block.control_observations) spoil_one(seen, kOfMarks);
}

Block shaped_block(std::uint64_t seed) {
  Block block = test_block({.points = 100, .control = 12, .seed = seed});
  Random random(seed, 31);
  spoil(block, random);
  for (auto& [id, point] : block.control) {
    point.sigma_m.setConstant(kControl_m);
    if (point.role == ControlRole::kControl) point.position_in_world += kControl_m * normal3(random);
  }
  return block;
}

TEST(ImageCovariance, CovarianceAndWhiteningAreOne) {
  for (const PixelShape& shape : {PixelShape{}, kOfMarks, kOfTies}) {
    const Eigen::Matrix2d w = shape.whitening();
    EXPECT_LT((w * shape.covariance() * w.transpose() - Eigen::Matrix2d::Identity()).norm(), 1e-12);
  }
}

// Squared residuals and tests are chi-squared and standard normal, errors of check points as large as their
// covariances.
TEST(ImageCovariance, ErrorsAreAsLargeAsTheirSigmas) {
  constexpr int kBlocks = 60;
  double squares = 0, redundancy = 0, checks = 0, tests = 0, marks = 0;
  long check_points = 0, tested_marks = 0, tested_ties = 0;
  double ties = 0;
  for (std::uint64_t seed = 1; seed <= kBlocks; ++seed) {
    ExamineOptions options = tested(Calibration::kFocal);
    options.test.sigma0_known = true;
    const Block block = shaped_block(seed);
    const auto adjusted = examine(block, {}, options, kRun);
    ASSERT_TRUE(adjusted) << adjusted.error().message;
    squares += adjusted->final_cost;
    redundancy += double(adjusted->redundancy);
    EXPECT_NEAR(adjusted->reliability->redundancy_sum, double(adjusted->redundancy), 1e-3);
    for (const ControlDifference& one : adjusted->control) {
      if (one.used || !one.covariance_m2) continue;
      const Eigen::Vector3d error = *one.position_in_world - block.control.at(one.point).position_in_world;
      checks += error.dot(one.covariance_m2->inverse() * error);
      ++check_points;
    }
    for (const TestedObservation& one : adjusted->reliability->others)
      if (one.group == ObservationGroup::kControlImages && std::isfinite(one.w)) {
        marks += one.w * one.w;
        ++tested_marks;
      }
    for (std::size_t i = 0; i < adjusted->observations.size(); ++i)
      for (int axis = 0; axis < 2; ++axis) {
        const double r = adjusted->reliability->tie_redundancy[i][axis];
        if (r < 0.05) continue;
        ties += std::pow(adjusted->residuals_px[i][axis] / block.observations[i].sigmas_px()[axis], 2) / r;
        ++tested_ties;
      }
  }
  EXPECT_NEAR(squares / redundancy, 1, 4 * std::sqrt(2 / redundancy));
  EXPECT_NEAR(checks / double(3 * check_points), 1, 4 * std::sqrt(2.0 / double(3 * check_points)));
  // Tests of one point are correlated: as if a third as many at the least.
  EXPECT_NEAR(marks / double(tested_marks), 1, 4 * std::sqrt(6.0 / double(tested_marks)));
  EXPECT_NEAR(ties / double(tested_ties), 1, 4 * std::sqrt(6.0 / double(tested_ties)));
}

TEST(ImageCovariance, AGrossErrorInOneCoordinateIsFound) {
  for (const int axis : {0, 1}) {
    Block block = shaped_block(7);
    const double wrong_px = 12 * kSigma_px * (axis == 0 ? 1 : kOfMarks.row_over_column);
    block.control_observations[20].pixel[axis] += wrong_px;
    const auto adjusted = examine(block, {}, tested(Calibration::kFocal), kRun);
    ASSERT_TRUE(adjusted && adjusted->reliability && !adjusted->reliability->suspects.empty());
    const TestedObservation& worst = adjusted->reliability->suspects[0];
    EXPECT_EQ(worst.group, ObservationGroup::kControlImages);
    EXPECT_EQ(worst.source, 20u);
    EXPECT_EQ(worst.axis, axis);
    EXPECT_NEAR(worst.gross_error, wrong_px, 4 * kSigma_px * (axis == 0 ? 1 : kOfMarks.row_over_column));
  }
}

TEST(ImageCovariance, WhatIsNoneIsRefused) {
  for (const PixelShape& shape : {PixelShape{0, 0}, PixelShape{1, 1}, PixelShape{-1, 0}, PixelShape{NAN, 0}}) {
    Block block = shaped_block(1);
    block.control_observations[0].shape = shape;
    EXPECT_EQ(examine(block, {}, tested(), kRun).error().code, Errc::kBadInput);
  }
}

// Scores of the lens and of its additional parameters are those of adjusting again with them.
TEST(ImageCovariance, ScoresAgreeWithAdjustingAgain) {
  Flown made = flown(3, {.b1_px = 0.05}, {.noise = false});
  Random random(3, 31);
  spoil(made.block, random);
  const ExamineOptions options = looking_for_systematics(made, Calibration::kBrown);
  const auto before = examine(made.block, made.scope, options, kRun);
  const auto after = adjust(made.block, made.scope, plain(Calibration::kBrownAffinity), kRun);
  ASSERT_TRUE(before && after);
  const auto affinity = std::ranges::find(before->systematics, SystematicKind::kAffinity, &SystematicTest::kind);
  ASSERT_NE(affinity, before->systematics.end());
  const double less = before->final_cost - after->final_cost;
  EXPECT_NEAR(affinity->statistic, less, 0.02 * less + 0.05);
  const auto& params = after->cameras.at({1}).params;
  EXPECT_NEAR(affinity->values[0], params[Camera::kB1], 0.1 * affinity->sigmas[0]);
  EXPECT_NEAR(affinity->values[1], params[Camera::kB2], 0.1 * affinity->sigmas[1]);
}

}  // namespace
}  // namespace collinea::testing
