// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "collinea/camera/camera.h"

namespace collinea::dense {

/// The camera of an image without distortion, for loops over all its pixels.
struct Pinhole {
  double f, cx, cy;

  explicit Pinhole(const Camera& camera)
      : f(camera.focal_px()), cx(camera.params[Camera::kCx]), cy(camera.params[Camera::kCy]) {}

  /// To the position (x, y) of the image, with z = 1.
  [[nodiscard]] Eigen::Vector3d ray(double x, double y) const { return {(x - cx) / f, (y - cy) / f, 1}; }

  /// Where a point with z > 0 is seen.
  [[nodiscard]] Eigen::Vector2d project(const Eigen::Vector3d& in_cam) const {
    return {f * in_cam.x() / in_cam.z() + cx, f * in_cam.y() / in_cam.z() + cy};
  }
};

}  // namespace collinea::dense
