// SPDX-License-Identifier: Apache-2.0
#include "collinea/geodesy/internal/ellipsoid.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

namespace collinea {
namespace {

TEST(Ellipsoid, TheEquatorAndThePoleLieOnTheAxes) {
  EXPECT_LT((geocentric_from_geographic({0, 0, 0}) - Eigen::Vector3d(6378137, 0, 0)).norm(), 1e-9);
  EXPECT_LT((geocentric_from_geographic({90, 0, 0}) - Eigen::Vector3d(0, 0, 6356752.314245)).norm(), 1e-6);
}

TEST(Ellipsoid, GeographicAndGeocentricRoundTripEverywhere) {
  for (double latitude = -90; latitude <= 90; latitude += 7.5)
    for (const double longitude : {-179.5, -90.0, 0.0, 13.4, 180.0})
      for (const double height_m : {-5000.0, 0.0, 120.0, 9000.0, 1e6}) {
        const Eigen::Vector3d geocentric = geocentric_from_geographic({latitude, longitude, height_m});
        const Eigen::Vector3d back = geographic_from_geocentric(geocentric);
        EXPECT_LT((geocentric_from_geographic(back) - geocentric).norm(), 1e-8);
        EXPECT_NEAR(back[0], latitude, 1e-12);
        EXPECT_NEAR(back[2], height_m, 1e-8);
      }
}

TEST(Ellipsoid, TheLocalAxesAreOrthonormalAndRightHanded) {
  const Eigen::Matrix3d axes = enu_from_geocentric(52.5, 13.4);
  EXPECT_LT((axes * axes.transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-14);
  EXPECT_LT((axes.row(0).cross(axes.row(1)) - axes.row(2)).norm(), 1e-14);
}

}  // namespace
}  // namespace collinea
