// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "collinea/epipolar/internal/point_pairs.h"
#include "collinea/epipolar/robust_start.h"
#include "collinea/geometry/rigid3.h"

namespace collinea {

/// A relative orientation found among pairs of which nearly half may be wrong, without a limit for their errors.
struct RelativeStart {
  Rigid3 second_from_first;  ///< translation of unit length
  std::vector<int> inliers;  ///< ascending
  double scale_px = 0;       ///< robust standard deviation of a Sampson distance
  int in_front = 0;          ///< inliers in front of both cameras
};

/// By samples of five pairs (five_point()) and the least median of squares, or the least sum of absolute Sampson
/// distances (robust_start()); of the four motions of the matrix that with most inliers in front of both cameras. The
/// kind kTruncated is for verify(), and answers as kLeastMedian here. Nothing with fewer than eight pairs, or when they
/// leave the motion undetermined (a plane leaves two motions, of which one is given; no base leaves none).
[[nodiscard]] std::optional<RelativeStart> relative_start(const PointPairs& pairs, RobustStart kind,
                                                          std::uint64_t seed);

}  // namespace collinea
