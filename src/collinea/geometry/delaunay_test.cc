// SPDX-License-Identifier: Apache-2.0
#include "collinea/geometry/delaunay.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "collinea/math/random.h"

namespace collinea {
namespace {

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

// Every triangle counter-clockwise, its circle empty up to `slack`, neighbours mutual, the whole hull covered.
void expect_delaunay(const std::vector<Eigen::Vector2d>& points, const Delaunay& made, double hull_area, double slack) {
  double area = 0;
  for (std::size_t t = 0; t < made.triangles().size(); ++t) {
    const auto& [corners, neighbours] = made.triangles()[t];
    const Eigen::Vector2d &a = points[std::size_t(corners[0])], &b = points[std::size_t(corners[1])],
                          &c = points[std::size_t(corners[2])];
    ASSERT_GT(cross(b - a, c - a), 0);
    area += cross(b - a, c - a) / 2;
    // Middle of the circle.
    const double d = 2 * cross(b - a, c - a);
    const Eigen::Vector2d u = b - a, v = c - a;
    const Eigen::Vector2d middle = a + Eigen::Vector2d(v.y() * u.squaredNorm() - u.y() * v.squaredNorm(),
                                                       u.x() * v.squaredNorm() - v.x() * u.squaredNorm()) /
                                           d;
    const double radius = (a - middle).norm();
    for (const Eigen::Vector2d& point : points) ASSERT_GT((point - middle).norm(), radius * (1 - slack));
    for (std::size_t i = 0; i < 3; ++i) {
      if (neighbours[i] < 0) continue;
      const auto& back = made.triangles()[std::size_t(neighbours[i])].neighbours;
      ASSERT_NE(std::find(back.begin(), back.end(), int(t)), back.end());
    }
  }
  EXPECT_NEAR(area, hull_area, 1e-6 * hull_area);
}

TEST(Delaunay, CirclesOfRandomPointsAreEmpty) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    std::vector<Eigen::Vector2d> points = {{0, 0}, {10, 0}, {10, 7}, {0, 7}};
    for (int i = 0; i < 150; ++i) points.emplace_back(random.uniform(0, 10), random.uniform(0, 7));
    const auto made = Delaunay::of(points);
    ASSERT_TRUE(made);
    expect_delaunay(points, *made, 70, 1e-6);
    // Euler: 2 n - 2 - points on the hull, four here.
    EXPECT_EQ(made->triangles().size(), 2 * points.size() - 2 - 4);
  }
}

TEST(Delaunay, GridsWhereFourPointsLieOnEveryCircle) {
  std::vector<Eigen::Vector2d> points;
  for (int y = 0; y < 12; ++y)
    for (int x = 0; x < 15; ++x) points.emplace_back(x, y);
  const auto made = Delaunay::of(points);
  ASSERT_TRUE(made);
  expect_delaunay(points, *made, 14.0 * 11, 1e-6);
  EXPECT_EQ(made->triangles().size(), std::size_t(2 * 14 * 11));
}

TEST(Delaunay, PointsOnOnePlaceTakePartOnce) {
  std::vector<Eigen::Vector2d> points = {{0, 0}, {1, 0}, {0, 1}, {0, 0}, {1, 0}, {1, 1}, {1, 1}};
  const auto made = Delaunay::of(points);
  ASSERT_TRUE(made);
  EXPECT_EQ(made->triangles().size(), 2u);
}

TEST(Delaunay, NothingWhereThereIsNoTriangle) {
  EXPECT_FALSE(Delaunay::of(std::vector<Eigen::Vector2d>{{0, 0}, {1, 1}}));
  EXPECT_FALSE(Delaunay::of(std::vector<Eigen::Vector2d>{{0, 0}, {1, 1}, {2, 2}, {5, 5}}));
  EXPECT_FALSE(Delaunay::of(std::vector<Eigen::Vector2d>{{3, 3}, {3, 3}, {3, 3}}));
  std::vector<Eigen::Vector2d> slanting;
  for (int i = 0; i < 50; ++i) slanting.emplace_back(i, i / 3.0);
  EXPECT_FALSE(Delaunay::of(slanting));
  EXPECT_FALSE(Delaunay::of(std::vector<Eigen::Vector2d>{{0, 0}, {1, 0}, {0, NAN}}));
}

TEST(Delaunay, FindsTheTriangleOfAPosition) {
  Random random(5);
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i < 3000; ++i) points.emplace_back(random.uniform(500'000, 500'900), random.uniform(5e6, 5.0007e6));
  const auto made = Delaunay::of(points);
  ASSERT_TRUE(made);
  int inside = 0;
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector2d position(random.uniform(500'000, 500'900), random.uniform(5e6, 5.0007e6));
    const auto location = made->find(position);
    if (!location) continue;
    ++inside;
    Eigen::Vector2d there = Eigen::Vector2d::Zero();
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_GE(location->weights[k], 0);
      there +=
          location->weights[k] * points[std::size_t(made->triangles()[std::size_t(location->triangle)].corners[k])];
    }
    EXPECT_LT((there - position).norm(), 1e-3);
  }
  EXPECT_GT(inside, 1900);
  EXPECT_FALSE(made->find({499'000, 5e6}));
}

}  // namespace
}  // namespace collinea
