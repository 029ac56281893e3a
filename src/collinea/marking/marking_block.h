// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <functional>
#include <map>
#include <optional>
#include <vector>

#include "collinea/marking/local_poses.h"
#include "collinea/quality/joint_poses.h"

namespace collinea {

/// The height of the surface at a position in plan of the world; nothing where none is known.
using SurfaceHeight = std::function<std::optional<double>(const Eigen::Vector2d& position_in_world)>;

/// What the adjustment of the whole block knows of some images together, by the given sigmas; nothing: not of these.
using PosesTogether = std::function<std::optional<JointPoses>(std::span<const ImageId>)>;

/// An oriented block, as it is asked for marks.
struct MarkingBlock {
  const Block& block;                                               ///< with tie points
  const std::map<ImageId, std::vector<std::size_t>>& observations;  ///< of each image, in Block::observations
  const PoseCovariances& poses;                                     ///< by the given sigmas; empty: not known
  double sigma0 = 1;
  SurfaceHeight surface = {};         ///< what may hide a point; empty: nothing does
  PosesTogether poses_together = {};  ///< empty: local_poses() stands for it
};

/// Of each image, indices in Block::observations.
[[nodiscard]] std::map<ImageId, std::vector<std::size_t>> observations_by_image(const Block& block);

/// Whether the surface rises above the line from a position to a projection centre, both in the world. Near the
/// position the surface is its own: what counts begins a few cells away, and stands out by a part of the way. No
/// surface: nothing is hidden.
[[nodiscard]] bool is_hidden(const SurfaceHeight& surface, const Eigen::Vector3d& position,
                             const Eigen::Vector3d& centre);

}  // namespace collinea
