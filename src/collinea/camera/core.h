// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/camera/camera.h"

namespace collinea {

/// What the mathematics needs of a camera, without its words: others may keep the numbers.
struct CameraCore {
  const double* params;  ///< Camera::params
  CameraModel model;
  AdditionalSet additional;
  PictureExtent size;
};

[[nodiscard]] inline CameraCore core_of(const Camera& camera) {
  return {camera.params.data(),
          camera.model,
          camera.additional,
          {static_cast<double>(camera.width_px), static_cast<double>(camera.height_px)}};
}

/// project() of camera.h.
[[nodiscard]] std::optional<Eigen::Vector2d> project(const CameraCore& camera, const Eigen::Vector3d& point_in_cam,
                                                     Matrix23* by_point, Matrix2P* by_params);

}  // namespace collinea
