// SPDX-License-Identifier: Apache-2.0
#include "collinea/block/gnss_vector.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <numbers>

#include "collinea/block/world_frame.h"

namespace collinea {
namespace {

GnssVector any_vector() {
  GnssVector vector{.vector = {812.31, -455.02, 23.5}};
  const Eigen::Matrix3d root = (Eigen::Matrix3d() << 5e-3, 0, 0, 2e-3, 4e-3, 0, -3e-3, 1e-3, 9e-3).finished();
  vector.covariance_m2 = root * root.transpose();
  return vector;
}

TEST(GnssVector, ItsPartsHaveTheSquaresOfAll) {
  const GnssVector vector = any_vector();
  const auto parts = observations_of(vector, {.from = {1}, .to = {2}, .setup = 4});
  ASSERT_TRUE(parts);
  const Eigen::Vector3d other = vector.vector + Eigen::Vector3d(0.01, -0.02, 0.005), off = other - vector.vector;
  double squares = 0;
  for (const GeodeticObservation& one : *parts) {
    EXPECT_EQ(one.setup, 4u);
    EXPECT_NEAR(one.along.norm(), 1, 1e-12);
    squares += std::pow((one.along.dot(other) - one.value) / one.sigma, 2);
  }
  EXPECT_NEAR(squares, off.dot(vector.covariance_m2.inverse() * off), 1e-6);
  const GnssVector back = vector_of(*parts);
  EXPECT_LT((back.vector - vector.vector).norm(), 1e-11);
  EXPECT_LT((back.covariance_m2 - vector.covariance_m2).norm(), 1e-15);
}

TEST(GnssVector, WhatIsNoCovarianceHasNoParts) {
  GnssVector vector = any_vector();
  vector.covariance_m2(0, 1) = vector.covariance_m2(1, 0) = 1;
  EXPECT_FALSE(observations_of(vector, {}));
  vector.covariance_m2.setZero();
  EXPECT_FALSE(observations_of(vector, {}));
  vector.covariance_m2 = Eigen::Vector3d(1, 1, NAN).asDiagonal();
  EXPECT_FALSE(observations_of(vector, {}));
}

// WGS84, Cartesian, by the formula of textbooks.
Eigen::Vector3d geocentric(const Eigen::Vector3d& lat_lon_height) {
  constexpr double kA = 6378137, kE2 = 0.00669437999014, kDegree = std::numbers::pi / 180;
  const double b = lat_lon_height.x() * kDegree, l = lat_lon_height.y() * kDegree, h = lat_lon_height.z();
  const double n = kA / std::sqrt(1 - kE2 * std::sin(b) * std::sin(b));
  return {(n + h) * std::cos(b) * std::cos(l), (n + h) * std::cos(b) * std::sin(l), (n * (1 - kE2) + h) * std::sin(b)};
}

TEST(GnssVector, AxesOfTheEarthAreTurnedToThoseOfTheWorld) {
  const Georeference position{"EPSG:32633", 48.2, 15.63, 300};
  const auto frame = world_frame(position);
  ASSERT_TRUE(frame);
  const Eigen::Vector3d from(1200, -700, 40), to(-300, 2500, -15);
  const Eigen::Vector3d vector =
      geocentric(frame->geographic_from_local(to)) - geocentric(frame->geographic_from_local(from));
  EXPECT_LT((world_from_geocentric(position) * vector - (to - from)).norm(), 1e-6);
}

}  // namespace
}  // namespace collinea
