// SPDX-License-Identifier: Apache-2.0
#include "collinea/match/window_return.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "collinea/match/internal/test_textures.h"

namespace collinea {
namespace {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using testing::image_of;
using testing::WaveTexture;

const Vector2d kPoint(28.3, 27.6), kFound(29.1, 26.9);

TEST(WindowReturn, LineOfAPointIsThatOfTheMatrix) {
  Matrix3d fundamental;
  fundamental << 1e-6, -2e-6, 3e-3, 4e-6, 1e-6, -1e-2, -2e-3, 9e-3, 1.5;
  const Vector2d p(412.5, 77.25), q(300, 200);
  const auto line = epipolar_line(fundamental, p);
  ASSERT_TRUE(line);
  const Eigen::Vector3d expected = fundamental * p.homogeneous();
  EXPECT_NEAR(line->distance_px(q), q.homogeneous().dot(expected) / expected.head<2>().norm(), 1e-9);
  EXPECT_NEAR(line->distance_px(line->foot_px(q)), 0, 1e-9);
  EXPECT_NEAR(line->direction().norm(), 1, 1e-12);
  EXPECT_NEAR(line->distance_px(line->foot_px(q) + 40 * line->direction()), 0, 1e-9);
  EXPECT_FALSE(epipolar_line(Matrix3d::Zero(), p));
  const Eigen::Vector3d epipole(412.5, 77.25, 1);
  Matrix3d through;  // [e]x: all lines pass the epipole, which has none itself
  through << 0, -epipole.z(), epipole.y(), epipole.z(), 0, -epipole.x(), -epipole.y(), epipole.x(), 0;
  EXPECT_FALSE(epipolar_line(through, p));
  EXPECT_TRUE(epipolar_line(through, q));
}

// What is found does not depend on the reference: on the way back noise is nearly the same, so that it comes back by a
// small part of the sigma; of every model, with any line.
TEST(WindowReturn, ComesBackToThePoint) {
  for (const auto& model : kWindowModelWords)
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      const WaveTexture texture(seed, 8, 24);
      const Vector2d line(0.6, -0.8);
      const Vector2d truth = model.value == WindowModel::kLine ? Vector2d(kPoint + 0.9 * line) : kFound;
      const GreyImage left = image_of(56, 56, texture, 2, 2 * seed);
      const GreyImage right = image_of(
          56, 56, [&](const Vector2d& at) { return texture(at - truth + kPoint); }, 2, 2 * seed + 1);
      WindowOptions options;
      options.model = model.value;
      const WindowStart start{kPoint + (model.value == WindowModel::kLine ? 0.4 * line : Vector2d(0.3, 0.1)),
                              Matrix2d::Identity(), line};
      const auto found = match_window_and_back(left, kPoint, right, start, options, line, 0.1);
      ASSERT_EQ(found.match.outcome, WindowOutcome::kFound) << model.word << seed;
      const double sigma = std::sqrt(found.match.covariance_px2.trace());
      EXPECT_LT((found.match.position_px - truth).norm(), 6 * sigma) << model.word << seed;
      EXPECT_LT(*found.returned_px, sigma) << model.word << seed;
    }
}

// Every other right image shows something else beyond a border near the point, as behind an edge of depth: what least
// squares finds is off, and from there the way back goes elsewhere. More than half of the wrong answers are refused,
// and no match of what both images show: 0.1 px is several times what comes back there.
TEST(WindowReturn, WrongAnswersDoNotComeBack) {
  int wrong = 0, wrong_passed = 0, seen = 0;
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    const WaveTexture texture(seed, 7, 24), other(seed + 1000, 7, 24);
    Random random(seed, 7);
    const bool is_hidden = seed % 2 == 0;
    const double border = kFound.x() + random.uniform(-4, 4);
    const GreyImage left = image_of(56, 56, texture, 2, 2 * seed);
    const GreyImage right = image_of(
        56, 56,
        [&](const Vector2d& at) { return is_hidden && at.x() > border ? other(at) : texture(at - kFound + kPoint); }, 2,
        2 * seed + 1);
    WindowOptions options;
    options.model = WindowModel::kTranslation;
    options.least_correlation = 0;
    options.largest_sigma_px = 1;
    const WindowStart start{kFound + Vector2d(random.uniform(-0.7, 0.7), random.uniform(-0.7, 0.7))};
    const auto plain = match_window(left, kPoint, right, start, options);
    if (plain.outcome != WindowOutcome::kFound) continue;
    const auto checked = match_window_and_back(left, kPoint, right, start, options, {1, 0}, 0.1);
    const bool passed = checked.match.outcome == WindowOutcome::kFound;
    EXPECT_EQ(checked.match.position_px, plain.position_px);
    if (is_hidden && (plain.position_px - kFound).norm() > 0.3) {
      ++wrong;
      wrong_passed += passed;
    }
    if (is_hidden) continue;
    ++seen;
    EXPECT_TRUE(passed) << seed;
  }
  ASSERT_GT(wrong, 40);
  ASSERT_GT(seen, 140);
  EXPECT_LE(wrong_passed, wrong / 2);
}

TEST(WindowReturn, WhatIsNotFoundDoesNotReturn) {
  const GreyImage flat(56, 56, 1, 90);
  const auto found = match_window_and_back(flat, kPoint, flat, {kPoint}, {}, {1, 0}, 1);
  EXPECT_EQ(found.match.outcome, WindowOutcome::kNoTexture);
  EXPECT_FALSE(found.returned_px);
}

}  // namespace
}  // namespace collinea
