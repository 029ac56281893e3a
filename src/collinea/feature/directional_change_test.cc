// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/directional_change.h"

#include <gtest/gtest.h>

#include <numbers>

namespace collinea {
namespace {

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

// Grey values 3 x - 5 y: nine pixels shifted by (1, 1), twice (0.5, 0.5), differ by 9 (3 - 5)^2.
TEST(DirectionalChange, IsMoravecsSumOfAPlane) {
  const double xx = 9 * 9, xy = 9 * -15, yy = 9 * 25;
  EXPECT_EQ(change_towards({1, 1}, xx, xy, yy), 9 * 4);
  EXPECT_EQ(change_towards({1, 0}, xx, xy, yy), 9 * 9);
  EXPECT_NEAR(4 * change_towards(shift_towards(std::numbers::pi / 4), xx, xy, yy), 9 * 4, 1e-12);
}

}  // namespace
}  // namespace collinea
