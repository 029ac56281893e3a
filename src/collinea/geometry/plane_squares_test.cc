// SPDX-License-Identifier: Apache-2.0
#include "collinea/geometry/plane_squares.h"

#include <gtest/gtest.h>

#include <numeric>

#include "collinea/math/random.h"

namespace collinea {
namespace {

std::vector<std::size_t> nearest_by_sorting(const std::vector<Eigen::Vector2d>& points, const Eigen::Vector2d& at,
                                            std::size_t count) {
  std::vector<std::size_t> order(points.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return std::pair((points[a] - at).squaredNorm(), a) < std::pair((points[b] - at).squaredNorm(), b);
  });
  order.resize(std::min(count, order.size()));
  return order;
}

TEST(PlaneSquares, FindsTheNearestInsideAndOutside) {
  Random random(3);
  for (const double height : {100.0, 0.01, 0.0}) {  // broad, a strip, a line
    std::vector<Eigen::Vector2d> points;
    for (int i = 0; i < 500; ++i) points.emplace_back(5e5 + random.uniform(0, 100), random.uniform(0, height));
    points.push_back(points.front());
    const PlaneSquares squares(points);
    for (int i = 0; i < 200; ++i) {
      const Eigen::Vector2d at(5e5 + random.uniform(-80, 180), random.uniform(-80, 180));
      std::vector<std::size_t> expected = nearest_by_sorting(points, at, 7);
      EXPECT_EQ(squares.nearest(at, 7), expected);
      std::erase_if(expected, [&](std::size_t k) { return (points[k] - at).norm() > 5; });
      EXPECT_EQ(squares.nearest(at, 7, 5), expected);
    }
  }
}

TEST(PlaneSquares, VisitsWhatLiesInASquare) {
  Random random(5);
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i < 800; ++i) points.emplace_back(random.uniform(0, 60), random.uniform(0, 40));
  const PlaneSquares squares(points);
  for (const Eigen::Vector2d& at : {Eigen::Vector2d(30, 20), Eigen::Vector2d(-3, 41)}) {
    std::vector<std::size_t> seen, expected;
    squares.in_square(at, 6, [&](std::size_t i) { seen.push_back(i); });
    for (std::size_t i = 0; i < points.size(); ++i)
      if ((points[i] - at).cwiseAbs().maxCoeff() <= 6) expected.push_back(i);
    std::sort(seen.begin(), seen.end());
    EXPECT_EQ(seen, expected);
  }
}

TEST(PlaneSquares, FewPointsAndNone) {
  EXPECT_TRUE(PlaneSquares({}).nearest({0, 0}, 3).empty());
  // Of as many equal distances as you like the lower indices.
  std::vector<Eigen::Vector2d> lattice;
  for (int i = 0; i < 400; ++i) lattice.emplace_back(i % 20, i / 20);
  for (const Eigen::Vector2d& at : {Eigen::Vector2d(7, 11), Eigen::Vector2d(7.5, 11), Eigen::Vector2d(19.5, -1)})
    EXPECT_EQ(PlaneSquares(lattice).nearest(at, 6), nearest_by_sorting(lattice, at, 6));
  const PlaneSquares two({{1, 1}, {1, 1}});
  EXPECT_EQ(two.nearest({9, 9}, 5), (std::vector<std::size_t>{0, 1}));
}

}  // namespace
}  // namespace collinea
