// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/curves.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "collinea/math/random.h"

namespace collinea {
namespace {

using Eigen::Vector2d;

Curve circle(double radius, int count, const Vector2d& centre = {50, 50}) {
  Curve out;
  for (int i = 0; i < count; ++i) {
    const double t = 2 * std::numbers::pi * i / count;
    out.push_back(centre + radius * Vector2d(std::cos(t), std::sin(t)));
  }
  return out;
}

Curve square() {
  Curve out;
  for (int i = 0; i < 20; ++i) out.emplace_back(10 + i, 10);
  for (int i = 0; i < 20; ++i) out.emplace_back(30, 10 + i);
  for (int i = 0; i < 20; ++i) out.emplace_back(30 - i, 30);
  for (int i = 0; i < 20; ++i) out.emplace_back(10, 30 - i);
  return out;
}

TEST(Curves, LengthAndArea) {
  EXPECT_DOUBLE_EQ(length_of(square(), true), 80);
  EXPECT_DOUBLE_EQ(length_of(square(), false), 79);
  EXPECT_DOUBLE_EQ(area_of(square()), 400);
  EXPECT_EQ(length_of({}, true), 0);
  const Curve even = resampled(circle(10, 1000), true, 36);
  for (int i = 0; i < 36; ++i)
    EXPECT_NEAR((even[std::size_t(i)] - even[std::size_t((i + 1) % 36)]).norm(),
                2 * 10 * std::sin(std::numbers::pi / 36), 1e-4);
  EXPECT_TRUE(resampled({}, true, 5).empty());
}

TEST(Curves, APolygonKeepsTheCorners) {
  const Curve corners = polygon_of(square(), true, 0.5);
  ASSERT_EQ(corners.size(), 4u);
  for (const Vector2d& p : corners) EXPECT_NEAR((p - Vector2d(20, 20)).cwiseAbs().minCoeff(), 10, 1e-12);
  const Curve line{{0, 0}, {1, 0.1}, {2, -0.1}, {3, 5}, {4, 6}, {5, 7}, {6, 8.1}, {7, 9}, {8, 9}, {9, 9}};
  const Curve kept = polygon_of(line, false, 1);
  EXPECT_EQ(kept, (Curve{{0, 0}, {2, -0.1}, {3, 5}, {7, 9}, {9, 9}}));
  // Nothing of the curve is farther off than the tolerance.
  const Curve coarse = polygon_of(circle(40, 500), true, 1);
  EXPECT_LT(coarse.size(), 20u);
  EXPECT_GT(area_of(coarse), std::numbers::pi * 39 * 39 * 0.98);
}

// Mussio A.22: 0 .. 7 by 45 degrees.
TEST(Curves, ChainCodes) {
  const ChainCode code = chain_code(Curve{{5.5, 5.5}, {7.5, 5.5}, {7.5, 3.5}, {5.5, 5.5}}, false);
  EXPECT_EQ(code.x, 5);
  EXPECT_EQ(code.steps, (std::vector<std::uint8_t>{0, 0, 2, 2, 5, 5}));
  EXPECT_EQ(curve_of(code).back(), Vector2d(5.5, 5.5));
  EXPECT_EQ(chain_code(square(), true).steps.size(), 80u);
  EXPECT_TRUE(chain_code({}, true).steps.empty());
}

// Mussio A.20: straight lines are level, circles are straight with the slope of their curvature.
TEST(Curves, PsiOfSOfACircleIsALine) {
  const auto right = psi_s(circle(25, 200), true, 5);
  ASSERT_EQ(right.size(), 200u);
  for (const PsiS& p : right) {
    EXPECT_NEAR(p.curvature_per_px, 1 / 25.0, 5e-4);  // a parabola is not a circle
    EXPECT_NEAR(p.psi_rad - right[0].psi_rad, p.s_px / 25, 2e-3);
  }
  Curve line;
  for (int i = 0; i < 40; ++i) line.emplace_back(10 + 0.8 * i, 20 + 0.6 * i);
  for (const PsiS& p : psi_s(line, false, 4)) {
    EXPECT_NEAR(p.psi_rad, std::atan2(0.6, 0.8), 1e-9);
    EXPECT_NEAR(p.curvature_per_px, 0, 1e-9);
  }
  EXPECT_TRUE(psi_s(Curve(4, {0, 0}), true, 5).empty());
}

TEST(Curves, TheSigmaOfACurvatureIsItsError) {
  double sum = 0;
  int count = 0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    Random random(seed);
    Curve noisy = circle(25, 160);
    for (Vector2d& p : noisy) p += 0.05 * random.normal() * (p - Vector2d(50, 50)).normalized();
    const auto shape = psi_s(noisy, true, 6);
    for (std::size_t i = 0; i < shape.size(); i += 16, ++count) {
      const double error = (shape[i].curvature_per_px - 1 / 25.0) / (0.05 * shape[i].sigma_curvature);
      sum += error * error;
    }
  }
  EXPECT_NEAR(sum / count, 1, 0.15);
}

TEST(Curves, FourierDescriptors) {
  const FourierDescriptors of_circle = fourier_descriptors(circle(25, 256), true, 8);
  EXPECT_NEAR(std::abs(of_circle(1)), 25, 0.01);
  EXPECT_NEAR(std::abs(of_circle(0) - std::complex<double>(50, 50)), 0, 1e-6);
  for (const double i : of_circle.invariants()) EXPECT_LT(i, 1e-4);
  const Curve back = fourier_descriptors(square(), true, 30).curve(80);
  for (std::size_t i = 0; i < 80; ++i) EXPECT_LT((back[i] - square()[i]).norm(), 0.35);
  // The same shape elsewhere, turned, larger and begun at another point.
  Curve other;
  const Curve original = square();
  for (std::size_t i = 0; i < original.size(); ++i) {
    const Vector2d p = original[(i + 17) % original.size()];
    other.emplace_back(3 * (0.8 * p.x() - 0.6 * p.y()) + 100, 3 * (0.6 * p.x() + 0.8 * p.y()) - 7);
  }
  const auto a = fourier_descriptors(original, true, 10).invariants();
  const auto b = fourier_descriptors(other, true, 10).invariants();
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], 5e-3);
  EXPECT_TRUE(fourier_descriptors({}, true, 5).at.empty());
  EXPECT_TRUE(fourier_descriptors(Curve(5, {1, 1}), true, 5).at.empty());
  EXPECT_EQ(fourier_descriptors(Curve{{0, 0}, {1, 0}, {3, 0}}, false, 4).at.size(), 9u);
}

}  // namespace
}  // namespace collinea
