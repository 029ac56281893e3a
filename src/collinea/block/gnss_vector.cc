// SPDX-License-Identifier: Apache-2.0
#include "collinea/block/gnss_vector.h"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <numbers>

namespace collinea {

std::optional<std::array<GeodeticObservation, 3>> observations_of(const GnssVector& vector,
                                                                  const GeodeticObservation& common) {
  if (!vector.vector.allFinite() || !vector.covariance_m2.allFinite()) return std::nullopt;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(vector.covariance_m2);
  constexpr double kSingular = 1e-12;  // of the largest variance: a direction that is known without error
  if (!(eigen.eigenvalues()[0] > kSingular * eigen.eigenvalues()[2])) return std::nullopt;
  std::array<GeodeticObservation, 3> observations;
  for (int axis = 0; axis < 3; ++axis) {
    GeodeticObservation& one = observations[static_cast<std::size_t>(axis)] = common;
    one.kind = GeodeticKind::kGnssVector;
    one.axis = axis;
    one.is_local = vector.is_local;
    one.along = eigen.eigenvectors().col(axis);
    one.value = one.along.dot(vector.vector);
    one.sigma = std::sqrt(eigen.eigenvalues()[axis]);
  }
  return observations;
}

GnssVector vector_of(const std::array<GeodeticObservation, 3>& observations) {
  GnssVector vector{.is_local = observations[0].is_local};
  for (const GeodeticObservation& one : observations) {
    vector.vector += one.value * one.along;
    vector.covariance_m2 += one.sigma * one.sigma * one.along * one.along.transpose();
  }
  return vector;
}

std::vector<std::uint32_t> with_their_vectors(const Block& block, std::uint32_t observation) {
  const GeodeticObservation& one = block.geodetic[observation];
  std::vector<std::uint32_t> all;
  for (std::uint32_t i = 0; i < block.geodetic.size(); ++i) {
    const GeodeticObservation& other = block.geodetic[i];
    const bool is_of_it = other.kind == GeodeticKind::kGnssVector && other.kind == one.kind && other.setup == one.setup;
    if (i == observation || is_of_it) all.push_back(i);
  }
  return all;
}

// Rows: east, north and up at the origin, along x, y and z of the Earth.
Eigen::Matrix3d world_from_geocentric(const Georeference& georeference) {
  constexpr double kDegree = std::numbers::pi / 180;
  const double latitude = georeference.origin_latitude_deg * kDegree,
               longitude = georeference.origin_longitude_deg * kDegree;
  const double sl = std::sin(longitude), cl = std::cos(longitude), sp = std::sin(latitude), cp = std::cos(latitude);
  return (Eigen::Matrix3d() << -sl, cl, 0, -sp * cl, -sp * sl, cp, cp * cl, cp * sl, sp).finished();
}

}  // namespace collinea
