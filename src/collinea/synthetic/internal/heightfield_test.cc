// SPDX-License-Identifier: Apache-2.0
#include "collinea/synthetic/internal/heightfield.h"

#include <gtest/gtest.h>

#include <cmath>

#include "collinea/math/random.h"

namespace collinea {
namespace {

Heightfield rough() {
  Random random(3);
  std::vector<float> heights;
  for (int i = 0; i < 40 * 30; ++i) heights.push_back(float(random.uniform(-1, 1)));
  return {-10, -8, 0.5, 40, 30, heights};
}

TEST(Heightfield, IsBilinearBetweenItsNodes) {
  const Heightfield field(10, 20, 2, 2, 2, {1, 3, 5, 11});
  EXPECT_DOUBLE_EQ(field.height(10, 20), 1);
  EXPECT_DOUBLE_EQ(field.height(12, 20), 3);
  EXPECT_DOUBLE_EQ(field.height(10, 22), 5);
  EXPECT_DOUBLE_EQ(field.height(11, 21), 5);  // the mean of the corners
  EXPECT_DOUBLE_EQ(field.height(50, 20), 3);  // beyond the grid: the nearest position
}

// Coordinates of about 20 m in double: rounding of a quadratic's root leaves 1e-13 or so; 1e-9 leaves room for grazing
// rays.
TEST(Heightfield, RaysEndOnTheSurfaceAndNotBehindIt) {
  const Heightfield field = rough();
  Random random(4);
  int met = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    const Eigen::Vector3d from(random.uniform(-9, 8), random.uniform(-7, 6), 1.5);
    const Eigen::Vector3d to(random.uniform(-9, 8), random.uniform(-7, 6), random.uniform(-1.5, 1.0));
    const auto t = field.meet(from, to - from, 0, 1);
    const double end = t.value_or(1);
    for (int i = 0; i < 200; ++i) {
      const Eigen::Vector3d p = from + (end * i / 200) * (to - from);
      ASSERT_GT(p.z() - field.height(p.x(), p.y()), -1e-9) << "trial " << trial;
    }
    if (!t) continue;
    ++met;
    const Eigen::Vector3d p = from + *t * (to - from);
    EXPECT_NEAR(p.z(), field.height(p.x(), p.y()), 1e-9);
  }
  EXPECT_GT(met, 1000);
}

TEST(Heightfield, PlumbLinesMeetTheHeight) {
  const Heightfield field = rough();
  const auto t = field.meet({1.3, 2.2, 10}, {0, 0, -1}, 0, 20);
  ASSERT_TRUE(t);
  EXPECT_NEAR(10 - *t, field.height(1.3, 2.2), 1e-12);
}

// A saddle of which a level ray sees only the middle: it dips and comes up again inside one cell.
TEST(Heightfield, DipsInsideOneCellAreFound) {
  const Heightfield field(0, 0, 1, 2, 2, {0, 1, 1, 0});
  const auto t = field.meet({0, 0, 0.45}, Eigen::Vector3d(1, 1, 0), 0, 1);
  ASSERT_TRUE(t);
  EXPECT_NEAR(2 * *t * (1 - *t), 0.45, 1e-12);
  EXPECT_LT(*t, 0.5);
}

TEST(Heightfield, NormalsArePerpendicularToTheSurface) {
  const Heightfield field = rough();
  const double x = 1.63, y = 2.21, h = 1e-4;
  const Eigen::Vector3d normal = field.normal(x, y);
  EXPECT_NEAR(normal.dot(Eigen::Vector3d(2 * h, 0, field.height(x + h, y) - field.height(x - h, y))), 0, 1e-12);
  EXPECT_NEAR(normal.dot(Eigen::Vector3d(0, 2 * h, field.height(x, y + h) - field.height(x, y - h))), 0, 1e-12);
  EXPECT_GT(normal.z(), 0);
}

}  // namespace
}  // namespace collinea
