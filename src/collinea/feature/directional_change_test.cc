// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "collinea/feature/interest.h"

namespace collinea {
namespace {

// A shift of the analytic form of Moravec's operator: the change of a window towards it is sum (u I_x + v I_y)^2.
struct DirectedShift {
  double u = 0, v = 0;  // [px]
};

// The shift towards a direction w (from the v axis, u / v = tan w), written with |u| + |v| = 1 as Karfis does (2.2.2):
// 45 degrees are (0.5, 0.5). Diagonal shifts are thus shorter, by sqrt(2), than those along the axes.
DirectedShift shift_towards(double direction_rad) {
  const double u = std::sin(direction_rad), v = std::cos(direction_rad), sum = std::abs(u) + std::abs(v);
  return {u / sum, v / sum};
}

// Change of a window with the sums of products of its gradients xx, xy, yy (the structure tensor) [grey^2]: what
// Moravec's sum of squared differences over the shift is where grey values are linear.
double change_towards(DirectedShift shift, double xx, double xy, double yy) {
  return shift.u * shift.u * xx + 2 * shift.u * shift.v * xy + shift.v * shift.v * yy;
}

// Karfis W6: 45 degrees are (0.5, 0.5); the axes are (1, 0) and (0, 1).
TEST(DirectionalChange, DirectionsOfKarfisW6) {
  constexpr double kRightAngle = std::numbers::pi / 2;
  const DirectedShift diagonal = shift_towards(kRightAngle / 2);
  EXPECT_NEAR(diagonal.u, 0.5, 1e-15);
  EXPECT_NEAR(diagonal.v, 0.5, 1e-15);
  EXPECT_NEAR(shift_towards(kRightAngle).u, 1, 1e-15);
  EXPECT_NEAR(shift_towards(0).v, 1, 1e-15);
  for (double direction = 0; direction < kRightAngle; direction += 0.1) {
    const DirectedShift shift = shift_towards(direction);
    EXPECT_NEAR(shift.u / shift.v, std::tan(direction), 1e-12 * (1 + std::tan(direction)));
    EXPECT_NEAR(shift.u + shift.v, 1, 1e-15);
  }
}

// Grey values 100 + 3 x - 5 y: what the operator finds is the least of the analytic changes towards its shifts, the
// diagonal ones twice as long as with |u| + |v| = 1. 9 (3 - 5)^2 here.
TEST(DirectionalChange, IsMoravecsOperatorOnAPlane) {
  GreyImage image(15, 15, 1);
  for (int y = 0; y < 15; ++y)
    for (int x = 0; x < 15; ++x) image.at(x, y) = std::uint8_t(100 + 3 * x - 5 * y);
  const double xx = 9 * 9, xy = 9 * -15, yy = 9 * 25;
  double least = INFINITY;
  for (int eighth = 0; eighth < 8; ++eighth) {
    const double length = eighth % 2 == 0 ? 1 : 2;
    const DirectedShift shift = shift_towards(eighth * std::numbers::pi / 4);
    least = std::min(least, change_towards({length * shift.u, length * shift.v}, xx, xy, yy));
  }
  EXPECT_NEAR(least, 36, 1e-12);
  const FloatImage map = interest_map(image, {.method = InterestOperator::kMoravec});
  EXPECT_NEAR(map.at(7, 7), least, 1e-6);
}

}  // namespace
}  // namespace collinea
