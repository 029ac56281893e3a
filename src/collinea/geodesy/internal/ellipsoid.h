// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace collinea {

/// Earth-centred WGS84 coordinates [m] of (latitude deg, longitude deg, ellipsoidal height m).
[[nodiscard]] Eigen::Vector3d geocentric_from_geographic(const Eigen::Vector3d& lat_lon_height);

/// The inverse, by Bowring's iteration on the parametric latitude; exact to rounding (< 1e-8 m) for heights between
/// -100 km and 10,000 km. At the centre of the Earth and on its axis the longitude is 0.
[[nodiscard]] Eigen::Vector3d geographic_from_geocentric(const Eigen::Vector3d& geocentric);

/// Rows: east, north and up at a position, as directions of the Earth-centred frame.
[[nodiscard]] Eigen::Matrix3d enu_from_geocentric(double latitude_deg, double longitude_deg);

}  // namespace collinea
