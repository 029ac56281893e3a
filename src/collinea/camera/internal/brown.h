// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>

#include "collinea/camera/internal/central.h"
#include "collinea/camera/internal/parameters.h"

namespace collinea {

/// Brown (1971), as computer vision writes it: the polynomial D of camera/camera.h goes from where a point would be
/// seen to where it is seen, (xd, yd) = D(X/Z, Y/Z).
struct Brown : Central<Brown>, private CameraParameters {
  static constexpr std::string_view kName = "brown";
  static constexpr std::array<int, 10> kHas = {kF, kCx, kCy, kK1, kK2, kK3, kP1, kP2, kB1, kB2};

  static std::optional<Eigen::Vector2d> project(const double* params, const Eigen::Vector3d& point_in_cam,
                                                Matrix23* by_point, Matrix2P* by_params);
  /// By Newton iteration, to 1e-10 and better inside the image for lenses whose distortion does not fold back; outside
  /// that domain the nearest the iteration comes.
  static Eigen::Vector2d undistorted(const double* params, const Eigen::Vector2d& measured);
  friend constexpr bool operator==(const Brown&, const Brown&) { return true; }
};

}  // namespace collinea
