// SPDX-License-Identifier: Apache-2.0
#include "collinea/geodesy/geodetic_collinearity.h"

#include <gtest/gtest.h>

#include <cmath>

#include "collinea/geodesy/refraction_k.h"

namespace collinea {
namespace {

const GeodeticPosition kCentre{0.79, 0.16, 2500}, kPoint{0.7901, 0.1602, 320};
const CardanAngles kAngles = geocentric_angles({0.05, -0.03, 1.2}, kCentre);

TEST(GeodeticCollinearity, GeocentricCoordinatesAreThoseOfTheEllipsoid) {
  const double degree = M_PI / 180;
  const Eigen::Vector3d equator = geocentric({0, 0, 10}).position, pole = geocentric({90 * degree, 0, 0}).position;
  EXPECT_NEAR(equator.x(), 6378147, 1e-6);
  EXPECT_NEAR(pole.z(), 6356752.314245, 1e-6);
}

TEST(GeodeticCollinearity, DerivativesAgreeWithDifferences) {
  const auto seen = [](const GeodeticPosition& centre, const CardanAngles& angles, const GeodeticPosition& point) {
    return collinearity(0.15, centre, angles, point).xy;
  };
  const GeodeticCollinearity at = collinearity(0.15, kCentre, kAngles, kPoint);
  EXPECT_LT(at.denominator, 0);
  EXPECT_LT(at.xy.norm(), 0.15);
  int k = 0;
  for (double GeodeticPosition::*part :
       {&GeodeticPosition::latitude_rad, &GeodeticPosition::longitude_rad, &GeodeticPosition::height_m}) {
    const double step = k < 2 ? 1e-7 : 0.5;
    GeodeticPosition before = kPoint, after = kPoint;
    before.*part -= step;
    after.*part += step;
    const Eigen::Vector2d by_point = (seen(kCentre, kAngles, after) - seen(kCentre, kAngles, before)) / (2 * step);
    EXPECT_LT((by_point - at.by_point.col(k)).norm(), 1e-6 * at.by_point.col(k).norm()) << k;
    before = after = kCentre;
    before.*part -= step;
    after.*part += step;
    const Eigen::Vector2d by_centre = (seen(after, kAngles, kPoint) - seen(before, kAngles, kPoint)) / (2 * step);
    EXPECT_LT((by_centre - at.by_centre.col(k)).norm(), 1e-6 * at.by_centre.col(k).norm()) << k;
    ++k;
  }
}

// A vertical photograph sees the point below its centre in the middle, north up.
TEST(GeodeticCollinearity, VerticalPhotographSeesNorthUp) {
  const CardanAngles vertical = geocentric_angles({0, 0, 0}, kCentre);
  const GeodeticPosition below{kCentre.latitude_rad, kCentre.longitude_rad, 0};
  EXPECT_LT(collinearity(0.15, kCentre, vertical, below).xy.norm(), 1e-12);
  const GeodeticPosition north{kCentre.latitude_rad + 1e-5, kCentre.longitude_rad, 0};
  EXPECT_GT(collinearity(0.15, kCentre, vertical, north).xy.y(), 1e-3);
  EXPECT_NEAR(ellipsoidal_height_m(120, 45.5), 165.5, 1e-12);
}

// Mussio D.8, micrometres for c = 150 mm; 500 km is not physical with a constant K.
TEST(RefractionK, NumbersOfMussioD8) {
  const double table[4][4] = {{1e3, 0.5662, 1.4721, 3.0574},
                              {3e3, 1.6985, 4.4162, 9.1722},
                              {1e4, 5.6618, 14.7207, 30.5738},
                              {5e5, 283.09, 736.04, 1528.69}};
  for (const auto& row : table)
    for (int k = 0; k < 3; ++k) {
      const double shift_um = 1e3 * refraction_by_coefficient(50.0 * (k + 1), 150, row[0]).shift;
      EXPECT_NEAR(shift_um, row[k + 1], row[0] > 1e5 ? 5e-3 : 5e-5);
    }
}

// Mussio D.7: what the formula leaves out is 3 K h / 2 R of the shift at most (s = c), 0.03 h / 1000 with h in km.
// Beside the arc itself, a ray turned by beta = K d / 2 R where d = h s / c is the distance of the point seen straight.
TEST(RefractionK, MagnitudeOfMussioD7) {
  for (const double h_km : {1.0, 3.0, 10.0}) {
    const double c = 150, observed = 150, by_formula = refraction_by_coefficient(observed, c, 1e3 * h_km).shift;
    double exact = by_formula;
    for (int i = 0; i < 50; ++i) {
      const double beta = 0.13 / (2 * 6378) * h_km * (observed - exact) / c;
      exact = observed - c * std::tan(std::atan(observed / c) - beta);
    }
    const double left_out = (by_formula - exact) / exact;
    EXPECT_NEAR(left_out, 0.03e-3 * h_km, 0.005e-3 * h_km);
    EXPECT_NEAR(left_out / (1.5 * 0.13 / 6378 * h_km), 1, 1e-3);  // and terms of higher order
  }
}

TEST(RefractionK, SigmaFollowsTheDerivatives) {
  const double s = 100, c = 150, h = 3000;
  const double by_h = (refraction_by_coefficient(s, c, h + 1).shift - refraction_by_coefficient(s, c, h - 1).shift) / 2;
  const double by_s =
      (refraction_by_coefficient(s + 0.01, c, h).shift - refraction_by_coefficient(s - 0.01, c, h).shift) / 0.02;
  EXPECT_NEAR(refraction_by_coefficient(s, c, h, 0.02, 30).sigma, std::hypot(30 * by_h, 0.02 * by_s), 1e-12);
  const double a_h =
      (refraction_by_atmosphere(s, c, h + 1, 0).shift - refraction_by_atmosphere(s, c, h - 1, 0).shift) / 2;
  EXPECT_NEAR(refraction_by_atmosphere(s, c, h, 0, 0, 30).sigma, 30 * std::abs(a_h), 1e-12);
}

// On a level image the shift is the radial one; on a tilted image it is where the level one has it.
TEST(RefractionK, TiltedImagesAreComputedOnTheLevelOne) {
  const RefractionHeights heights{3200, 200, 20};
  for (const bool by_atmosphere : {false, true}) {
    const RefractionModel model{by_atmosphere};
    const Eigen::Vector2d xy(60, -80);
    const ImageRefraction level = refraction_in_image(xy, 150, {}, heights, model, 0.01);
    const RadialRefraction radial = by_atmosphere ? refraction_by_atmosphere(100, 150, 3200, 200, 0.01, 20)
                                                  : refraction_by_coefficient(100, 150, 3000, 0.01, 20);
    EXPECT_LT((level.shift - radial.shift * xy / 100).norm(), 1e-12);
    EXPECT_LT((level.sigma - radial.sigma * xy.cwiseAbs() / 100).norm(), 1e-9);
    // A ray at the same angle from the nadir turns by the same angle, whatever the attitude of the image.
    const CardanAngles angles{0.3, -0.2, 0.7};
    const Eigen::Matrix3d r = rotation_matrix(angles);
    const Eigen::Vector3d straight = r * Eigen::Vector3d(60, -80, -150),
                          seen_level(xy.x() + level.shift.x(), xy.y() + level.shift.y(), -150);
    const Eigen::Vector2d in_tilted = -150 * straight.head<2>() / straight.z();
    const ImageRefraction tilted = refraction_in_image(in_tilted, 150, angles, heights, model);
    const Eigen::Vector3d seen = r * seen_level;
    EXPECT_LT((in_tilted + tilted.shift + 150 * seen.head<2>() / seen.z()).norm(), 1e-12);
    EXPECT_NEAR(tilted.angle_rad, std::atan(100.0 / 150), 1e-12);
  }
  EXPECT_TRUE(refraction_in_image({0, 0}, 150, {}, heights, {}).shift.isZero(0));                // the nadir
  EXPECT_TRUE(refraction_in_image({0, 0}, 150, {M_PI / 2, 0, 0}, heights, {}).shift.isZero(0));  // the horizon
}

// At 3 km both agree within a fifth; at 10 km the constant K is too large, because the air thins out.
TEST(RefractionK, StandsBesideTheStandardAtmosphere) {
  const double low =
      refraction_by_atmosphere(100, 150, 3000, 0).shift / refraction_by_coefficient(100, 150, 3000).shift;
  const double high =
      refraction_by_atmosphere(100, 150, 20000, 0).shift / refraction_by_coefficient(100, 150, 20000).shift;
  EXPECT_GT(low, 0.6);
  EXPECT_LT(low, 1.5);
  EXPECT_LT(high, low);
}

}  // namespace
}  // namespace collinea
