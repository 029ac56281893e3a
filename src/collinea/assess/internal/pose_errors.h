// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>

#include "collinea/block/block.h"
#include "collinea/geometry/similarity3.h"

namespace collinea {

/// How far points are from where they should be [m].
struct PointErrors {
  std::size_t points = 0;
  Eigen::Vector3d rms_m = Eigen::Vector3d::Zero();   ///< per axis: east, north, up
  Eigen::Vector3d mean_m = Eigen::Vector3d::Zero();  ///< estimated minus true
  double rms_3d_m = 0;
  double worst_3d_m = 0;
};

/// Differences of corresponding points. All zero without points.
[[nodiscard]] PointErrors point_errors(std::span<const Eigen::Vector3d> estimated,
                                       std::span<const Eigen::Vector3d> truth);

struct PoseErrors {
  std::size_t images = 0, oriented = 0;         ///< in the truth; of these, in the block
  std::optional<PointErrors> centres;           ///< as they are; nothing when the block has no location on Earth
  std::optional<PointErrors> after_similarity;  ///< nothing with fewer than three centres, or on a line
  std::optional<double> scale;                  ///< of the similarity: truth over estimate
  double rotation_rms_deg = 0;                  ///< of the attitudes, after the similarity
};

/// Converts a point of the estimated world to the true one.
using ToTruth = std::function<Eigen::Vector3d(const Eigen::Vector3d&)>;

/// Projection centres against the truth, images matched by the file's name. `to_truth`: null when the block is not
/// georeferenced.
[[nodiscard]] PoseErrors pose_errors(const Block& block, const std::map<std::string, Rigid3>& true_cam_from_world,
                                     const ToTruth& to_truth);

/// Forward intersection of a marked point from its measured image points. Nothing with fewer than two rays or without
/// parallax.
[[nodiscard]] std::optional<Eigen::Vector3d> intersect_mark(const Block& block, ControlId mark);

/// Intersected marks of one role against their true positions, matched by name.
[[nodiscard]] PointErrors mark_errors(const Block& block, ControlRole role,
                                      const std::map<std::string, Eigen::Vector3d>& true_marks,
                                      const ToTruth& to_truth);

}  // namespace collinea
