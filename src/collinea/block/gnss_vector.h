// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "collinea/block/block.h"

namespace collinea {

/// A baseline between two points as GNSS receivers measure it, with its covariance.
struct GnssVector {
  Eigen::Vector3d vector = Eigen::Vector3d::Zero();         ///< from the one antenna to the other [m]
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Zero();  ///< of it
  /// Along east, north and up of the ellipsoid at the first point; else along x, y and z of the world.
  bool is_local = false;
};

/// A vector as three independent observations of kGnssVector, along the principal axes of its covariance: with the same
/// sum of squares, whatever the points are. What they have in common is in `common` (points, name, role, heights, and
/// in `setup` the number of the vector). Nothing when the covariance is none: it has to be positive definite.
[[nodiscard]] std::optional<std::array<GeodeticObservation, 3>> observations_of(const GnssVector& vector,
                                                                                const GeodeticObservation& common);

/// The inverse, from the observations of one vector.
[[nodiscard]] GnssVector vector_of(const std::array<GeodeticObservation, 3>& observations);

/// The observations of Block::geodetic that are of the same vector as one of them, which is among them.
[[nodiscard]] std::vector<std::uint32_t> with_their_vectors(const Block& block, std::uint32_t observation);

/// The rotation to the axes of the world from those of the Earth (x to the Greenwich meridian, z to the north pole).
[[nodiscard]] Eigen::Matrix3d world_from_geocentric(const Georeference& georeference);

}  // namespace collinea
