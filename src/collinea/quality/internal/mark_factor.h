// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "collinea/block/block.h"
#include "collinea/quality/mark_systems.h"

namespace collinea {

/// A mark with what its ray is made of.
struct MarkedRay {
  const Camera* camera = nullptr;
  Rigid3 cam_from_world;
  Eigen::Vector2d given;  ///< its image coordinates as they came
  double sigma_px = 1;
  double nearest = 0, farthest = 0;  ///< depths that a point in this image may have; both 0: not known
};

/// The factors at which many pairs of rays become coplanar, the most likely first: along the system's factor s the
/// determinant |b, R1' x1(s), R2' x2(s)| is a quadratic, and each positive root counts by how sharply s follows from
/// it. Distortion is not considered, which a lens that is no fisheye allows.
[[nodiscard]] std::vector<double> likely_factors(const std::vector<std::vector<MarkedRay>>& points, MarkSystem system);

}  // namespace collinea
