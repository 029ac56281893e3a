// SPDX-License-Identifier: Apache-2.0
#include "collinea/geodesy/internal/ellipsoid.h"

#include <cmath>
#include <numbers>

namespace collinea {
namespace {

constexpr double kSemiMajor_m = 6378137.0;
constexpr double kFlattening = 1 / 298.257223563;
constexpr double kEccentricity2 = kFlattening * (2 - kFlattening);
constexpr double kRadPerDeg = std::numbers::pi / 180;

}  // namespace

Eigen::Vector3d geocentric_from_geographic(const Eigen::Vector3d& lat_lon_height) {
  const double latitude = lat_lon_height[0] * kRadPerDeg, longitude = lat_lon_height[1] * kRadPerDeg;
  const double height = lat_lon_height[2], sin_latitude = std::sin(latitude);
  const double normal = kSemiMajor_m / std::sqrt(1 - kEccentricity2 * sin_latitude * sin_latitude);
  const double from_axis = (normal + height) * std::cos(latitude);
  return {from_axis * std::cos(longitude), from_axis * std::sin(longitude),
          (normal * (1 - kEccentricity2) + height) * sin_latitude};
}

Eigen::Vector3d geographic_from_geocentric(const Eigen::Vector3d& geocentric) {
  const double from_axis = std::hypot(geocentric.x(), geocentric.y()), z = geocentric.z();
  const double semi_minor_m = kSemiMajor_m * (1 - kFlattening);
  const double second_eccentricity2 = kEccentricity2 / (1 - kEccentricity2);
  // Angles are carried as (cosine, sine): no trigonometric function inside the iteration.
  Eigen::Vector2d parametric = Eigen::Vector2d((1 - kFlattening) * from_axis, z).normalized(), latitude;
  for (int i = 0; i < 4; ++i) {
    const double c = parametric[0], s = parametric[1];
    latitude = Eigen::Vector2d(from_axis - kEccentricity2 * kSemiMajor_m * c * c * c,
                               z + second_eccentricity2 * semi_minor_m * s * s * s)
                   .normalized();
    parametric = Eigen::Vector2d(latitude[0], (1 - kFlattening) * latitude[1]).normalized();
  }
  const double c = latitude[0], s = latitude[1];
  // Unlike from_axis / cos - normal this form is well conditioned at the poles too.
  const double height = from_axis * c + z * s - kSemiMajor_m * std::sqrt(1 - kEccentricity2 * s * s);
  return {std::atan2(s, c) / kRadPerDeg, std::atan2(geocentric.y(), geocentric.x()) / kRadPerDeg, height};
}

Eigen::Matrix3d enu_from_geocentric(double latitude_deg, double longitude_deg) {
  const double latitude = latitude_deg * kRadPerDeg, longitude = longitude_deg * kRadPerDeg;
  const double sb = std::sin(latitude), cb = std::cos(latitude), sl = std::sin(longitude), cl = std::cos(longitude);
  Eigen::Matrix3d rows;
  rows << -sl, cl, 0, -sb * cl, -sb * sl, cb, cb * cl, cb * sl, sb;
  return rows;
}

}  // namespace collinea
