// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "collinea/camera/internal/fisheye.h"

namespace collinea {

/// Fisheye: equal solid angles have equal areas, g = 2 sin(t / 2).
struct Equisolid : Fisheye<Equisolid>, private CameraParameters {
  static constexpr std::string_view kName = "equisolid";
  static constexpr std::array<int, 10> kHas = {kF, kCx, kCy, kK1, kK2, kK3, kP1, kP2, kB1, kB2};
  /// The focal length of a lens that shows 180 degrees from corner to corner, in diagonals of the image.
  static constexpr double kFocalPerDiagonal = 1 / (2 * std::numbers::sqrt2);

  static FisheyeRadius radius(double angle_rad) { return {2 * std::sin(angle_rad / 2), std::cos(angle_rad / 2)}; }
  static double angle_rad(double g) { return 2 * std::asin(std::min(1.0, g / 2)); }
  friend constexpr bool operator==(const Equisolid&, const Equisolid&) { return true; }
};

}  // namespace collinea
