// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/edge_curve.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "collinea/feature/edges.h"
#include "collinea/feature/test_shapes.h"

namespace collinea {
namespace {

using Eigen::Vector2d;

constexpr double kNoise_grey = 5;

// A peanut: all of its even harmonics are there, its curvature changes its sign.
double radius_at(double angle) { return 34 + 7 * std::cos(2 * angle) + 2.5 * std::cos(3 * angle + 0.4); }
FloatImage peanut() {
  const auto white = [](const Vector2d& p) {
    const Vector2d q = p - Vector2d(60.3, 59.6);
    const double angle = std::atan2(q.y(), q.x()), h = 1e-3;
    const double slope = (radius_at(angle + h) - radius_at(angle - h)) / (2 * h) / q.norm();
    return blurred_step((radius_at(angle) - q.norm()) / std::hypot(1.0, slope), 0.9);
  };
  return render_shape(120, 120, white);
}
std::span<const EdgePoint> longest(const EdgeMap& map) {
  const auto chain = std::max_element(map.chains.begin(), map.chains.end(),
                                      [](const EdgeChain& a, const EdgeChain& b) { return a.count < b.count; });
  return map.points_of(*chain);
}

// Against the same edge without noise, at its nearest point: a bias that a parabola or smoothing has is in both. Points
// 1.5 windows apart hardly share pixels: 100 images with some 9 of them each. (e / sigma)^2 is then 1 with a standard
// deviation of sqrt(2 / n); four of those, and 0.1 beside: sigmas of the points themselves hold to 5 %.
TEST(EdgeCurve, SigmasOfDirectionAndCurvatureAreThoseOfTheErrors) {
  constexpr double kWindow_px = 7;
  const FloatImage image = peanut();
  const EdgeMap exact = detect_edges(image, {.noise_grey = kNoise_grey});
  const auto truth_points = longest(exact);
  const auto truth = psi_s(truth_points, true, exact.along_px, kWindow_px);
  double psi = 0, curvature = 0;
  int count = 0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    const EdgeMap map = detect_edges(with_noise(image, kNoise_grey, seed), {.noise_grey = kNoise_grey});
    const auto points = longest(map);
    ASSERT_GT(points.size(), 150u);
    const auto shape = psi_s(points, true, map.along_px, kWindow_px);
    for (std::size_t i = 10; i < shape.size(); i += 21, ++count) {
      std::size_t at = 0;
      for (std::size_t k = 0; k < truth_points.size(); ++k)
        if ((truth_points[k].at - points[i].at).norm() < (truth_points[at].at - points[i].at).norm()) at = k;
      // Along the edge to the nearest true point: the direction turns by the curvature.
      const double way = Vector2d(-points[i].normal.y(), points[i].normal.x()).dot(points[i].at - truth_points[at].at);
      const double sense =
          std::cos(shape[i].psi_rad) * -points[i].normal.y() + std::sin(shape[i].psi_rad) * points[i].normal.x();
      const double expected = truth[at].psi_rad + (sense > 0 ? way : -way) * truth[at].curvature_per_px;
      psi += std::pow(std::remainder(shape[i].psi_rad - expected, 2 * std::numbers::pi) / shape[i].sigma_psi_rad, 2);
      curvature += std::pow((shape[i].curvature_per_px - truth[at].curvature_per_px) / shape[i].sigma_curvature, 2);
    }
  }
  ASSERT_GT(count, 700);
  EXPECT_NEAR(psi / count, 1, 4 * std::sqrt(2.0 / count) + 0.1);
  EXPECT_NEAR(curvature / count, 1, 4 * std::sqrt(2.0 / count) + 0.1);
}

// Harmonics of the same edge without noise as truth; those of five sigmas and more, whose magnitude is linear in noise.
TEST(EdgeCurve, SigmasOfDescriptorsAreThoseOfTheErrors) {
  constexpr int kImages = 100;
  const FloatImage image = peanut();
  const EdgeMap exact = detect_edges(image, {.noise_grey = kNoise_grey});
  const EdgeDescriptors truth = edge_descriptors(longest(exact), exact.along_px, 4);
  ASSERT_EQ(truth.invariants.size(), 7u);
  double radius = 0, invariants = 0;
  int count = 0;
  for (std::uint64_t seed = 1; seed <= kImages; ++seed) {
    const EdgeMap map = detect_edges(with_noise(image, kNoise_grey, seed), {.noise_grey = kNoise_grey});
    const EdgeDescriptors found = edge_descriptors(longest(map), map.along_px, 4);
    ASSERT_EQ(found.invariants.size(), truth.invariants.size());
    radius += std::pow((found.radius_px - truth.radius_px) / found.sigma_radius_px, 2);
    for (std::size_t i = 0; i < truth.invariants.size(); ++i) {
      if (truth.invariants[i] < 5 * truth.sigmas[i]) continue;
      invariants += std::pow((found.invariants[i] - truth.invariants[i]) / found.sigmas[i], 2);
      ++count;
    }
  }
  ASSERT_GE(count, 4 * kImages);
  EXPECT_NEAR(radius / kImages, 1, 4 * std::sqrt(2.0 / kImages));
  // Those of one image have noise in common: as if there were one of each image.
  EXPECT_NEAR(invariants / count, 1, 4 * std::sqrt(2.0 / kImages));
}

TEST(EdgeCurve, IndependentErrorsAreThoseOfTheCurve) {
  std::vector<EdgePoint> points;
  Curve curve;
  for (int k = 0; k < 60; ++k) {
    const Vector2d out(std::cos(k * std::numbers::pi / 30), std::sin(k * std::numbers::pi / 30));
    points.push_back({.at = 20 * out, .normal = out, .sigma_px = 0.1});
    curve.push_back(points.back().at);
  }
  const auto plain = psi_s(curve, true, 8), scaled = psi_s(points, true, 1e-3, 8);
  ASSERT_EQ(plain.size(), scaled.size());
  for (std::size_t i = 0; i < plain.size(); ++i) {
    EXPECT_NEAR(scaled[i].sigma_curvature, 0.1 * plain[i].sigma_curvature, 1e-12);
    EXPECT_NEAR(scaled[i].sigma_psi_rad, 0.1 * plain[i].sigma_psi_rad, 1e-12);
    EXPECT_EQ(scaled[i].curvature_per_px, plain[i].curvature_per_px);
  }
  EXPECT_TRUE(psi_s(std::span<const EdgePoint>(points).first(4), false, 1, 8).empty());
  EXPECT_TRUE(edge_descriptors({}, 1, 8).invariants.empty());
  EXPECT_TRUE(edge_descriptors(std::vector<EdgePoint>(9, points[0]), 1, 8).invariants.empty());
}

}  // namespace
}  // namespace collinea
