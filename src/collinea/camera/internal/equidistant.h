// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <numbers>

#include "collinea/camera/internal/fisheye.h"

namespace collinea {

/// Fisheye: the distance from the principal point is f times the angle from the axis, g = t.
struct Equidistant : Fisheye<Equidistant>, private CameraParameters {
  static constexpr std::string_view kName = "equidistant";
  static constexpr std::array<int, 10> kHas = {kF, kCx, kCy, kK1, kK2, kK3, kP1, kP2, kB1, kB2};
  /// The focal length of a lens that shows 180 degrees from corner to corner, in diagonals of the image.
  static constexpr double kFocalPerDiagonal = 1 / std::numbers::pi;

  static FisheyeRadius radius(double angle_rad) { return {angle_rad, 1}; }
  static double angle_rad(double g) { return std::min(g, std::numbers::pi); }
  friend constexpr bool operator==(const Equidistant&, const Equidistant&) { return true; }
};

}  // namespace collinea
