// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

#include "collinea/camera/camera.h"
#include "collinea/math/least_median.h"
#include "collinea/orient/space_resection.h"

namespace collinea {

/// Whether a pose of pose_starts() says that the mark of a point is wrong: it is behind the camera, or off by more than
/// wrong_beyond() of the scale and of its own sigma.
[[nodiscard]] inline bool contradicts(const Camera& camera, const PoseStart& start,
                                      const Eigen::Vector3d& point_in_world, const Eigen::Vector2d& pixel,
                                      double sigma_px) {
  const auto seen = project(camera, start.cam_from_world * point_in_world);
  return !seen || (*seen - pixel).norm() > wrong_beyond(2) * std::max(start.scale_px, sigma_px);
}

}  // namespace collinea
