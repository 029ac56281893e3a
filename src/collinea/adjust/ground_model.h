// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "collinea/block/ground.h"

namespace collinea {

/// A measurement on the ground as two points foretell it, with its derivatives.
struct GroundModel {
  double computed = 0;                                                                 ///< [m] or [rad]
  Eigen::Vector3d by_from = Eigen::Vector3d::Zero(), by_to = Eigen::Vector3d::Zero();  ///< [1] or [rad/m]
  double by_orientation = 0;
};

/// `level_at_origin`: the z axis of the world is the plumb line at its origin and the Earth is a sphere there, of mean
/// radius; otherwise z is up everywhere. Zenith angles are bent by refraction then (k = 0.13). `orientation_rad`:
/// azimuth of zero of the horizontal circle, used by directions. Nothing is defined where the points coincide (or, for
/// directions, stand above each other): derivatives are zero then.
[[nodiscard]] GroundModel ground_model(const GroundObservation& observation, const Eigen::Vector3d& from,
                                       const Eigen::Vector3d& to, double orientation_rad, bool level_at_origin);

/// Observed minus computed; angles between -pi and pi.
[[nodiscard]] double ground_residual(const GroundObservation& observation, const GroundModel& model);

}  // namespace collinea
