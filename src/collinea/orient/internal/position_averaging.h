// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <limits>
#include <numbers>
#include <optional>
#include <span>
#include <vector>

#include "collinea/base/run.h"

namespace collinea {

/// Standard deviation of a pair's direction while the lens is not yet known: a focal length wrong by a percent and a
/// lens with distortion turn the directions of all pairs alike, so that what would be one degree of chance for one pair
/// does not average out.
inline constexpr double kDirectionSigma_rad = 3 * std::numbers::pi / 180;

/// The direction from one camera to another, as a pair of images has it.
struct RelativeDirection {
  int first = 0, second = 0;
  Eigen::Vector3d direction;  ///< unit length
};

/// Where a receiver says a camera was; infinite sigma: not measured.
struct ReceivedPosition {
  Eigen::Vector3d position_in_world = Eigen::Vector3d::Zero();
  Eigen::Vector3d sigma_m = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());  ///< [m]
};

/// The rotation from the frame of the directions to the world of the positions, by the bases between received
/// positions, robustly. Nothing when the bases do not stand out of the errors of the receivers, or all lie along one
/// line (a single strip): then nothing fixes the turn about it.
[[nodiscard]] std::optional<Eigen::Quaterniond> world_from_directions(std::span<const RelativeDirection> directions,
                                                                      std::span<const ReceivedPosition> received);

/// Projection centres from received positions and directions, both in the world: least squares of what the bases lie
/// off their directions and the centres off the positions, both robust, by reweighting. Cameras without a position
/// are placed by their directions alone.
[[nodiscard]] std::vector<Eigen::Vector3d> average_positions(std::span<const RelativeDirection> directions,
                                                             std::span<const ReceivedPosition> received,
                                                             const Run& run);

}  // namespace collinea
