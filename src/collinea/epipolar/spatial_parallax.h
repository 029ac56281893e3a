// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "collinea/geometry/rigid3.h"

namespace collinea {

/// Where two rays come nearest to each other, in the first camera, in units of the length of the base (Mussio 3.3.3;
/// the model point is the middle of the parallax: E28, E29).
struct SpatialParallax {
  Eigen::Vector3d point_in_first;
  Eigen::Vector3d parallax;                  ///< from the first ray to the second
  double along_first = 0, along_second = 0;  ///< distances from the projection centres; positive in front
};
/// Nothing where the rays are parallel (within 1e-7 rad). Image coordinates are X/Z, Y/Z.
[[nodiscard]] std::optional<SpatialParallax> spatial_parallax(const Rigid3& second_from_first,
                                                              const Eigen::Vector2d& first,
                                                              const Eigen::Vector2d& second);

}  // namespace collinea
