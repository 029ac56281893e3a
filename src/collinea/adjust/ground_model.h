// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "collinea/block/ground.h"

namespace collinea {

/// A measurement on the ground as points and unknowns of its own foretell it, with its derivatives.
struct GroundModel {
  double computed = 0;                                                                 ///< [m] or [rad]
  Eigen::Vector3d by_from = Eigen::Vector3d::Zero(), by_to = Eigen::Vector3d::Zero();  ///< [1] or [rad/m]
  std::array<double, 3> by_extra{};  ///< unknowns of its own: orientation of the set-up, or of a shape
  int extras = 0;                    ///< how many of them
};

/// Where a shape that points lie on begins: a frame of three axes in the world, seen from which it is described.
struct GroundShape {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  ///< by columns; of a plane the last is the normal, of a line:
                                                       ///< sideways, upwards, along it
};

/// The numbers that describe a shape against its frame, and how many of them one of its observations sees.
[[nodiscard]] constexpr int unknowns_of_shape(GroundKind kind) {
  return kind == GroundKind::kAtHeight ? 1 : kind == GroundKind::kOnPlane ? 3 : 4;
}

/// The fewest points that determine a shape.
[[nodiscard]] constexpr int points_of_shape(GroundKind kind) {
  return kind == GroundKind::kAtHeight ? 1 : kind == GroundKind::kOnPlane ? 3 : 2;
}

/// The frame of the shape that fits points best; all its unknowns then are zero, but for a common height, which counts
/// from the world's origin. Nothing: they are too few, or do not determine it (all in one place; of a plane also all on
/// one line: across it they reach less than a thousandth of its length).
[[nodiscard]] std::optional<GroundShape> shape_through(GroundKind kind, const std::vector<Eigen::Vector3d>& points);

/// How far a point is off the shape, along what observations of it are measured: upwards, along the normal, or across
/// the line along one of its axes (by the line as it is; to the second order of how far that turned from where it
/// began). `unknowns`: of a height one, of a plane offset and two tilts, of a line offset and tilt along
/// observation.axis.
[[nodiscard]] GroundModel shape_model(const GroundObservation& observation, const GroundShape& shape,
                                      const double* unknowns, const Eigen::Vector3d& point, bool level_at_origin);

/// `level_at_origin`: the z axis of the world is the plumb line at its origin and the Earth is a sphere there, of mean
/// radius; otherwise z is up everywhere. Zenith angles are bent by refraction then (k = 0.13). `orientation_rad`:
/// azimuth of zero of the horizontal circle, used by directions. Nothing is defined where the points coincide (or, for
/// directions, stand above each other): derivatives are zero then.
[[nodiscard]] GroundModel ground_model(const GroundObservation& observation, const Eigen::Vector3d& from,
                                       const Eigen::Vector3d& to, double orientation_rad, bool level_at_origin);

/// Observed minus computed; angles between -pi and pi.
[[nodiscard]] double ground_residual(const GroundObservation& observation, const GroundModel& model);

}  // namespace collinea
