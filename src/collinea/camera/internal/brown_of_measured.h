// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>

#include "collinea/camera/internal/central.h"
#include "collinea/camera/internal/parameters.h"

namespace collinea {

/// Brown (1971), as photogrammetry writes it: the polynomial D of camera/camera.h corrects measured coordinates,
/// D(xd, yd) = (X/Z, Y/Z). Neither direction is the inverse polynomial of the other.
struct BrownOfMeasured : Central<BrownOfMeasured>, private CameraParameters {
  static constexpr std::string_view kName = "brown_of_measured";
  static constexpr std::array<int, 10> kHas = {kF, kCx, kCy, kK1, kK2, kK3, kP1, kP2, kB1, kB2};

  /// By Newton iteration, to rounding.
  static std::optional<Eigen::Vector2d> project(const double* params, const Eigen::Vector3d& point_in_cam,
                                                Matrix23* by_point, Matrix2P* by_params);
  static Eigen::Vector2d undistorted(const double* params, const Eigen::Vector2d& measured);
  friend constexpr bool operator==(const BrownOfMeasured&, const BrownOfMeasured&) { return true; }
};

}  // namespace collinea
