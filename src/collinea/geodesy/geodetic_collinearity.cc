// SPDX-License-Identifier: Apache-2.0
#include "collinea/geodesy/geodetic_collinearity.h"

#include <cmath>
#include <numbers>

#include "collinea/geodesy/internal/ellipsoid.h"

namespace collinea {
namespace {

constexpr double kSemiMajor_m = 6378137, kFlattening = 1 / 298.257223563;
constexpr double kSquaredEccentricity = kFlattening * (2 - kFlattening);

}  // namespace

Geocentric geocentric(const GeodeticPosition& p) {
  const double sf = std::sin(p.latitude_rad), cf = std::cos(p.latitude_rad);
  const double sl = std::sin(p.longitude_rad), cl = std::cos(p.longitude_rad);
  const double w = std::sqrt(1 - kSquaredEccentricity * sf * sf);
  const double across = kSemiMajor_m / w;                                        // radius across the meridian
  const double along = kSemiMajor_m * (1 - kSquaredEccentricity) / (w * w * w);  // and along it
  const Eigen::Vector3d up(cf * cl, cf * sl, sf), north(-sf * cl, -sf * sl, cf), east(-sl, cl, 0);
  Geocentric out;
  constexpr double kDegrees = 180 / std::numbers::pi;
  out.position = geocentric_from_geographic({kDegrees * p.latitude_rad, kDegrees * p.longitude_rad, p.height_m});
  out.by_geodetic << (along + p.height_m) * north, (across + p.height_m) * cf * east, up;
  return out;
}

GeodeticCollinearity collinearity(double principal_distance, const GeodeticPosition& centre, const CardanAngles& angles,
                                  const GeodeticPosition& point) {
  const Geocentric from = geocentric(centre), to = geocentric(point);
  const CollinearityAt at = collinearity({principal_distance, from.position, angles}, to.position);
  return {at.xy, at.denominator, at.by_centre * from.by_geodetic, at.by_point * to.by_geodetic, at.by_angles};
}

CardanAngles geocentric_angles(const CardanAngles& against_east_north_up, const GeodeticPosition& centre) {
  const Eigen::Matrix3d level_from_geocentric =
      rotation_matrix(GeodeticAngles{centre.latitude_rad, centre.longitude_rad, std::numbers::pi / 2});
  return cardan_angles(rotation_matrix(against_east_north_up) * level_from_geocentric);
}

}  // namespace collinea
