// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>

#include "collinea/epipolar/intersect.h"
#include "collinea/quality/internal/measurement.h"

namespace collinea {

/// The free network of a block: its images, tie points and marks of control, adjusted by image points alone.
struct MarkNetwork {
  Block block;                                  ///< with the poses and tie points of the network
  std::map<ControlId, Eigen::Vector3d> marked;  ///< where the images see control and check points, in its frame
  std::map<PointId, Eigen::Vector3d> points;    ///< where they see tie points
  double typical_sigmas = 1;                    ///< of their residuals: the median over that of normal ones
};

/// By how much a sight line misses a position, 10,000 px where its image does not see it and at most.
[[nodiscard]] double miss_px(const SightLine& line, const Eigen::Vector3d& position);

/// Adjusts the free network by Huber's and then Cauchy's loss, marks of control like tie points, cameras as they stand.
/// No coordinate, position or measurement on the ground takes part, so that none can bend it, and an image point that
/// is wrong by any amount counts as little as one by some sigmas. Before each adjustment every point is intersected
/// again by those two of its rays that the others agree with best: a point that one wrong ray has drawn behind a camera
/// would never come back. The datum is that of the poses given. What is not measured in other images stays.
///
/// Errors: those of adjust().
[[nodiscard]] Result<MarkNetwork> mark_network_of(const Measurements& given, const Run& run);

}  // namespace collinea
