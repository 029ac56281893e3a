// SPDX-License-Identifier: Apache-2.0
#include "collinea/geometry/collinearity.h"

#include <gtest/gtest.h>

#include <cmath>

namespace collinea {
namespace {

TEST(Collinearity, NumbersOfMussioD8) {
  const CollinearityPhoto photo{0.15, {10, 20, 1000}, {0.05, -0.08, 0.6}};
  const CollinearityAt at = collinearity(photo, {250, -130, 40});
  EXPECT_NEAR(at.xy.x(), 0.00356926981963, 1e-13);
  EXPECT_NEAR(at.xy.y(), -0.03959936020634, 1e-13);
  EXPECT_NEAR(at.denominator, -967.4403535539, 1e-9);
  const Eigen::Vector3d x_centre(-1.272627866e-4, -8.674254331e-5, -1.826217426e-5);
  const Eigen::Vector3d x_angles(-0.08053351544, 0.1244024858, -0.03959936021);
  const Eigen::Vector3d y_centre(8.39957896e-5, -1.301958514e-4, 4.134204918e-5);
  const Eigen::Vector3d y_angles(-0.1311893247, -0.09137686919, -0.00356926982);
  EXPECT_LT((at.by_centre.row(0).transpose() - x_centre).norm(), 1e-12);
  EXPECT_LT((at.by_centre.row(1).transpose() - y_centre).norm(), 1e-12);
  EXPECT_LT((at.by_angles.row(0).transpose() - x_angles).norm(), 1e-9);
  EXPECT_LT((at.by_angles.row(1).transpose() - y_angles).norm(), 1e-9);
}

TEST(Collinearity, DerivativesAgreeWithDifferences) {
  const CollinearityPhoto photo{0.15, {10, 20, 1000}, {0.3, -0.4, 2.6}};
  const Eigen::Vector3d point(250, -130, 40);
  const CollinearityAt at = collinearity(photo, point);
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3d step = 1e-3 * Eigen::Vector3d::Unit(k);
    const Eigen::Vector2d by = (collinearity(photo, point + step).xy - collinearity(photo, point - step).xy) / 2e-3;
    EXPECT_LT((by - at.by_point.col(k)).norm(), 1e-12);
    CollinearityPhoto before = photo, after = photo;
    double CardanAngles::*angle = k == 0   ? &CardanAngles::omega_rad
                                  : k == 1 ? &CardanAngles::phi_rad
                                           : &CardanAngles::kappa_rad;
    before.angles.*angle -= 1e-6;
    after.angles.*angle += 1e-6;
    const Eigen::Vector2d by_angle = (collinearity(after, point).xy - collinearity(before, point).xy) / 2e-6;
    EXPECT_LT((by_angle - at.by_angles.col(k)).norm(), 1e-8);
  }
}

// Karfis W11: what the standard deviations of omega, phi and kappa of Volos and Kea are at x = y = 75 mm of a vertical
// photograph, along rows (dx) and across them (dy), added up as though they were independent. (The effects on y of Kea
// stand beside 2.35 px, not the printed 0.7: epipolar_lines_test.cc.)
TEST(Collinearity, EffectsOfTheAnglesByKarfisW11) {
  const double degree = M_PI / 180;
  const struct {
    double c_mm, omega, phi, kappa, dx_mm, dy_mm, dx_digit, dy_digit;
  } pairs[] = {{153.353, 0.0018, 0.0022, 0.0007, 0.00744, 0.00620, 1e-5, 1e-5},
               {152.52, 0.0344, 0.0229, 0.0057, 0.0792, 0.1149, 1e-4, 1e-4}};
  for (const auto& pair : pairs) {
    const CollinearityPhoto photo{pair.c_mm, {0, 0, 1000}, {}};
    const CollinearityAt at = collinearity(photo, {75 * 1000 / pair.c_mm, 75 * 1000 / pair.c_mm, 0});
    EXPECT_LT((at.xy - Eigen::Vector2d(75, 75)).norm(), 1e-12);
    const Eigen::Vector2d effect =
        (at.by_angles * degree * Eigen::Vector3d(pair.omega, pair.phi, pair.kappa).asDiagonal()).rowwise().norm();
    EXPECT_NEAR(effect.x(), pair.dx_mm, 0.5 * pair.dx_digit);
    EXPECT_NEAR(effect.y(), pair.dy_mm, 0.5 * pair.dy_digit);
  }
}

}  // namespace
}  // namespace collinea
