// SPDX-License-Identifier: Apache-2.0
#include "collinea/geometry/circle_fit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace collinea {
namespace {

using Eigen::Vector2d;

TEST(AlgebraicCircle, PassesThroughPointsOfACircle) {
  for (const std::size_t count : {3u, 4u, 9u}) {
    std::vector<Vector2d> points;
    for (std::size_t i = 0; i < count; ++i)
      points.push_back(Vector2d(0.4, -0.2) + 1.5 * Vector2d(std::cos(0.7 * double(i)), std::sin(0.7 * double(i))));
    const auto circle = algebraic_circle(points);
    ASSERT_TRUE(circle);
    EXPECT_LT((circle->centre - Vector2d(0.4, -0.2)).norm(), 1e-12);
    EXPECT_NEAR(circle->radius, 1.5, 1e-12);
    EXPECT_GT(circle->conditioning, 1e-3);
  }
}

// The equation of points off the circle by the same distance outwards and inwards in turn.
TEST(AlgebraicCircle, LiesBetweenPointsOffIt) {
  std::vector<Vector2d> points;
  for (int i = 0; i < 8; ++i)
    points.push_back((i % 2 == 0 ? 1.01 : 0.99) * Vector2d(std::cos(M_PI / 4 * i), std::sin(M_PI / 4 * i)));
  const auto circle = algebraic_circle(points);
  ASSERT_TRUE(circle);
  EXPECT_LT(circle->centre.norm(), 1e-12);
  EXPECT_NEAR(circle->radius, std::sqrt((1.01 * 1.01 + 0.99 * 0.99) / 2), 1e-12);
}

TEST(AlgebraicCircle, ALineHasNone) {
  const std::vector<Vector2d> points{{-1, -0.5}, {0, 0}, {0.4, 0.2}, {1, 0.5}};
  const auto circle = algebraic_circle(points);
  EXPECT_TRUE(!circle || circle->conditioning < 1e-12);
}

}  // namespace
}  // namespace collinea
