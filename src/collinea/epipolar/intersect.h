// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "collinea/block/block.h"

namespace collinea {

/// A measured image point with all that is needed to look along it.
struct SightLine {
  const Camera* camera = nullptr;
  Rigid3 cam_from_world;
  Eigen::Vector2d pixel;
  double sigma_px = 1;  ///< as Observation::sigma_px
  PixelShape shape;
};

/// A point where sight lines meet.
struct Intersection {
  Eigen::Vector3d point_in_world;
  Eigen::Matrix3d covariance;                 ///< [m^2], by the sigmas of the pixels alone
  std::vector<Eigen::Vector2d> residuals_px;  ///< observed minus computed, one for each line
  double sigma0 = 0;                          ///< of unit weight; a pair of lines has a redundancy of 1
};

/// Forward intersection by weighted least squares of the pixels; poses and cameras are taken as exact. Nothing with
/// fewer than two lines, when they are too parallel to fix a depth, or when they meet behind a camera.
[[nodiscard]] std::optional<Intersection> intersect(std::span<const SightLine> lines);

/// The sight lines of a control point in the oriented images of the block; `indices` (may be null) receives their
/// indices in Block::control_observations.
[[nodiscard]] std::vector<SightLine> sight_lines(const Block& block, ControlId point,
                                                 std::vector<std::size_t>* indices = nullptr);

}  // namespace collinea
