// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "collinea/geometry/collinearity.h"

namespace collinea {

// The collinearity equations in geodetic coordinates (Mussio 1.3.6-1.3.8), for photographs over so large an area that
// no plane map holds them, and for adjustments together with geodetic networks.

/// Latitude, longitude (east positive) and height above the WGS84 ellipsoid.
struct GeodeticPosition {
  double latitude_rad = 0, longitude_rad = 0, height_m = 0;
};

/// The ellipsoidal height of a point whose height above the sea is known: h = H + N, N the geoid's undulation.
[[nodiscard]] inline double ellipsoidal_height_m(double orthometric_m, double undulation_m) {
  return orthometric_m + undulation_m;
}

/// Geocentric coordinates [m] and their derivatives by latitude, longitude (rad) and height (m).
struct Geocentric {
  Eigen::Vector3d position;
  Eigen::Matrix3d by_geodetic;
};
[[nodiscard]] Geocentric geocentric(const GeodeticPosition& position);

/// Where a point is seen by a photograph whose centre is geodetic too; the angles turn the geocentric axes into the
/// image. Derivatives by latitude, longitude (rad) and height of both; those by the angles stay as they are.
struct GeodeticCollinearity {
  Eigen::Vector2d xy;
  double denominator = 0;
  Eigen::Matrix<double, 2, 3> by_centre, by_point, by_angles;
};
[[nodiscard]] GeodeticCollinearity collinearity(double principal_distance, const GeodeticPosition& centre,
                                                const CardanAngles& angles, const GeodeticPosition& point);

/// The Cardan angles, against the geocentric axes, of a photograph whose angles are known against east, north and up
/// at its centre.
[[nodiscard]] CardanAngles geocentric_angles(const CardanAngles& against_east_north_up, const GeodeticPosition& centre);

}  // namespace collinea
