// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
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

/// Rays through the corners of an image in its world, upper left, upper right, lower right, lower left, each as long as
/// reaches the depth of one: their ends lie in a plane square to the optical axis. Nothing of a camera that sees a
/// corner at a right angle to its axis or farther round.
[[nodiscard]] std::optional<std::array<Eigen::Vector3d, 4>> corner_rays(const Camera& camera,
                                                                        const Rigid3& cam_from_world);

}  // namespace collinea
