// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/target.h"

#include "collinea/feature/edges.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <functional>
#include <numbers>

#include "collinea/feature/test_shapes.h"

namespace collinea {
namespace {

using Eigen::Vector2d;
using Eigen::VectorXd;

using White = std::function<double(const Vector2d&)>;

double line_distance(const Vector2d& p, const Vector2d& at, double angle) {
  return -std::sin(angle) * (p.x() - at.x()) + std::cos(angle) * (p.y() - at.y());
}

White target_at(TargetKind kind, const Vector2d& at, double angle) {
  if (kind == TargetKind::kCircle)
    return [=](const Vector2d& p) {
      const Vector2d d = p - at;
      const double c = std::cos(angle), s = std::sin(angle);
      const Vector2d q((c * d.x() + s * d.y()) / 7, (-s * d.x() + c * d.y()) / 5);
      const double f = q.norm(), slope = Vector2d(q.x() / 7, q.y() / 5).norm() / std::max(f, 1e-9);
      return f < 0.3 ? 1.0 : blurred_step((1 - f) / slope, 0.6);
    };
  if (kind == TargetKind::kCross)
    return [=](const Vector2d& p) {
      double ground = 1;
      for (const double a : {angle, angle + 1.4}) {
        const double t = std::abs(line_distance(p, at, a));
        ground *= 1 - blurred_step(1.5 - t, 0.6);
      }
      return 1 - ground;
    };
  return [=](const Vector2d& p) {
    const double a = 2 * blurred_step(line_distance(p, at, angle), 0.6) - 1;
    const double b = 2 * blurred_step(line_distance(p, at, angle + 1.7), 0.6) - 1;
    return 0.5 + 0.5 * a * b;
  };
}

class TargetOfEachKind : public testing::TestWithParam<TargetKind> {};

TEST_P(TargetOfEachKind, DerivativesAreTheNumericOnes) {
  VectorXd u(GetParam() == TargetKind::kCircle ? 10 : GetParam() == TargetKind::kCross ? 11 : 9);
  u.head(7) << 10.2, 9.8, 0.9, 40, 0.5, -0.3, 100;
  if (GetParam() == TargetKind::kCircle) u.tail(3) << 6, 4, 0.4;
  if (GetParam() == TargetKind::kCross) u.tail(4) << 0.3, 1.7, 1.2, 1.6;
  if (GetParam() == TargetKind::kChequerboard) u.tail(2) << 0.3, 1.7;
  for (const Vector2d& p : {Vector2d(10.5, 9.1), Vector2d(14.5, 11.5), Vector2d(7.5, 6.5), Vector2d(12.5, 13.5)}) {
    VectorXd d;
    (void)target_grey(GetParam(), u, p, &d);
    for (int k = 0; k < u.size(); ++k) {
      VectorXd plus = u, minus = u;
      plus[k] += 1e-5;
      minus[k] -= 1e-5;
      EXPECT_NEAR(d[k], (target_grey(GetParam(), plus, p) - target_grey(GetParam(), minus, p)) / 2e-5, 2e-5) << k;
    }
  }
}

TEST_P(TargetOfEachKind, IsMeasuredToAHundredthOfAPixelWithoutNoise) {
  for (int k = 0; k < 12; ++k) {
    const Vector2d at(20 + 0.083 * k, 20.9 - 0.071 * k);
    const FloatImage image = render_shape(41, 41, target_at(GetParam(), at, 0.26 * k));
    const auto target = measure_target(image, GetParam(), {20.5, 20.5}, 11);
    ASSERT_TRUE(target) << k;
    EXPECT_LT((target->at - at).norm(), 0.003) << k;
  }
}

// 300 targets with noise: 0.02 px, and chi-squared of the covariance.
TEST_P(TargetOfEachKind, CovariancesAreTheErrors) {
  double sum = 0, within = 0, count = 0, squares = 0;
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    Random random(seed, 3);
    static FloatImage clean;
    static Vector2d at;
    if (seed % 10 == 1) {
      at = {20 + random.uniform(), 20 + random.uniform()};
      clean = render_shape(41, 41, target_at(GetParam(), at, random.uniform(0, 3)));
    }
    const FloatImage image = with_noise(clean, 4, seed);
    const auto target = measure_target(image, GetParam(), {20.5, 20.5}, 11);
    ASSERT_TRUE(target) << seed;
    const Vector2d error = target->at - at;
    const double chi = error.dot(target->covariance.inverse() * error);
    sum += chi / 2;
    within += chi < 5.991;
    squares += error.squaredNorm() / 2;
    ++count;
    EXPECT_NEAR(target->sigma_grey, 4, 1);
  }
  EXPECT_NEAR(sum / count, 1, 0.2);
  EXPECT_NEAR(within / count, 0.95, 0.035);
  EXPECT_LT(std::sqrt(squares / count), 0.02);
}

TEST_P(TargetOfEachKind, NothingWhereThereIsNone) {
  EXPECT_FALSE(measure_target(FloatImage(41, 41, 1, 100), GetParam(), {20, 20}, 11));
  EXPECT_FALSE(measure_target(with_noise(FloatImage(41, 41, 1, 100), 4, 3), GetParam(), {20, 20}, 11));
  EXPECT_FALSE(measure_target(render_shape(41, 41, half_plane(0.3, 24, 0.7), 2), GetParam(), {20, 20}, 11));
  const FloatImage image = render_shape(41, 41, target_at(GetParam(), {20, 20}, 0.5));
  EXPECT_FALSE(measure_target(image, GetParam(), {2, 2}, 11));
  EXPECT_FALSE(measure_target(image, GetParam(), {20, std::nan("")}, 11));
  EXPECT_FALSE(measure_target({}, GetParam(), {20, 20}, 11));
}

TEST_P(TargetOfEachKind, AllOfAnImageAreFound) {
  const std::vector<Vector2d> truth{{25.3, 26.1}, {70.8, 30.4}, {28.2, 75.7}, {75.1, 72.6}};
  const auto world = [&](const Vector2d& p) {
    const Vector2d& at = truth[std::size_t(p.x() > 50) + 2 * std::size_t(p.y() > 50)];
    const bool is_near = (p - at).cwiseAbs().maxCoeff() < 16;
    return is_near ? target_at(GetParam(), at, 0.3)(p) : 0.3;
  };
  const FloatImage image = render_shape(100, 100, world, 3);
  const EdgeMap edges = detect_edges(image, {});
  const auto found = find_targets(image, edges, GetParam(), {.radius_px = 9});
  for (const Vector2d& at : truth)
    EXPECT_TRUE(std::any_of(found.begin(), found.end(), [&](const Target& t) { return (t.at - at).norm() < 0.08; }))
        << at.transpose();
}

INSTANTIATE_TEST_SUITE_P(Targets, TargetOfEachKind,
                         testing::Values(TargetKind::kCircle, TargetKind::kCross, TargetKind::kChequerboard),
                         [](const auto& tested) { return std::string(word_of(tested.param)); });

// Pixels that were smoothed have errors in common: the covariance must grow with them.
TEST(Targets, CorrelatedNoiseIsAllowedFor) {
  double sum = 0;
  int count = 0, noticed = 0;
  for (std::uint64_t seed = 1; seed <= 120; ++seed) {
    const FloatImage clean = render_shape(41, 41, target_at(TargetKind::kChequerboard, {20.3, 20.6}, 0.4));
    const FloatImage noise = smoothed(with_noise(FloatImage(41, 41), 12, seed), 0.8);
    FloatImage image = clean;
    for (std::size_t i = 0; i < image.data.size(); ++i) image.data[i] += noise.data[i];
    const auto target = measure_target(image, TargetKind::kChequerboard, {20.5, 20.5}, 11);
    ASSERT_TRUE(target);
    const Vector2d error = target->at - Vector2d(20.3, 20.6);
    sum += error.dot(target->covariance.inverse() * error) / 2;
    noticed += target->has_correlated_residuals;
    ++count;
  }
  EXPECT_EQ(noticed, count);
  EXPECT_GT(sum / count, 0.7);
  EXPECT_LT(sum / count, 1.8);
}

}  // namespace
}  // namespace collinea
