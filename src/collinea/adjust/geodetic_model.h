// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "collinea/adjust/internal/geodetic_kinds.h"

namespace collinea {

/// The numbers that describe a shape against its frame, and how many of them one of its observations sees.
[[nodiscard]] constexpr int unknowns_of_shape(GeodeticKind kind) {
  int unknowns = 0;
  geodetic::visit_kind<geodetic::ShapeKinds>(kind, [&]<class Shape>() { unknowns = Shape::kUnknowns; });
  return unknowns;
}

/// The fewest points that determine a shape.
[[nodiscard]] constexpr int points_of_shape(GeodeticKind kind) {
  int points = 0;
  geodetic::visit_kind<geodetic::ShapeKinds>(kind, [&]<class Shape>() { points = Shape::kPoints; });
  return points;
}

/// The frame of the shape that fits points best; all its unknowns then are zero, but for a common height, which counts
/// from the world's origin. Nothing: they are too few, or do not determine it (all at one position; of a plane also all
/// on one line: across it they reach less than a thousandth of its length).
[[nodiscard]] std::optional<GeodeticShape> shape_through(GeodeticKind kind, const std::vector<Eigen::Vector3d>& points);

/// How far a point is off the shape, along what observations of it are measured: upwards, along the normal, or across
/// the line along one of its axes (by the line as it is; to the second order of how far that turned from where it
/// began). `unknowns`: of a height one, of a plane offset and two tilts, of a line offset and tilt along
/// observation.axis.
[[nodiscard]] GeodeticModel shape_model(const GeodeticObservation& observation, const GeodeticShape& shape,
                                        const double* unknowns, const Eigen::Vector3d& point, const Earth& earth);

/// Where the Earth is round zenith angles are bent by refraction (k = 0.13). `orientation_rad`:
/// azimuth of zero of the horizontal circle, used by directions. Nothing is defined where the points coincide (or, for
/// directions, stand above each other): derivatives are zero then.
[[nodiscard]] GeodeticModel geodetic_model(const GeodeticObservation& observation, const Eigen::Vector3d& from,
                                           const Eigen::Vector3d& to, double orientation_rad, const Earth& earth);

/// Observed minus computed; angles between -pi and pi.
[[nodiscard]] double geodetic_residual(const GeodeticObservation& observation, const GeodeticModel& model);

}  // namespace collinea
