// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "collinea/camera/camera.h"
#include "collinea/geometry/rigid3.h"

namespace collinea {

/// Where the outline of an image meets the horizontal plane at a height of the world: four points a side, in order.
/// Nothing when a part of it looks over the horizon, or farther away than ten times its height over the plane.
[[nodiscard]] std::optional<std::vector<Eigen::Vector3d>> image_footprint(const Camera& camera,
                                                                          const Rigid3& cam_from_world,
                                                                          double height_in_world);

}  // namespace collinea
