// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <span>
#include <vector>

#include "collinea/base/run.h"

namespace collinea {

/// What a pair of cameras says of their rotations. Cameras are numbers from 0.
struct RelativeRotation {
  int first = 0, second = 0;
  Eigen::Quaterniond second_from_first = Eigen::Quaterniond::Identity();
  double weight = 1;  ///< of its square; more matches say more
};

/// cam_from_world of `count` cameras that hang together by pairs, in an arbitrary world: pairs count by their
/// weight and by the share of their triangles that close; a spanning tree of the heaviest, then corrections by
/// iteratively reweighted least squares (sum of absolute angles first, then Geman and McClure's loss at the scale of
/// the residuals), after Chatterjee and Govindu (PAMI 2018). Wrong pairs do no harm as long as most pairs of every
/// camera are right. Cameras that do not hang together with camera 0 keep the rotation of a tree of their own.
[[nodiscard]] std::vector<Eigen::Quaterniond> average_rotations(int count, std::span<const RelativeRotation> pairs,
                                                                const Run& run);

/// A direction that a camera sees and that is known in the world.
struct SeenDirection {
  int camera;
  Eigen::Vector3d in_camera, in_world;  ///< of length one
  double sigma_rad;
};

/// Turns the cameras so that the pairs keep their relative rotations and the directions are met, by least squares with
/// robust weights. It takes away what small errors common to all pairs add up to over a large block.
void rotate_towards(std::span<const RelativeRotation> pairs, std::span<const SeenDirection> directions,
                    std::vector<Eigen::Quaterniond>& cam_from_world, const Run& run);

}  // namespace collinea
