// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <numbers>

#include "collinea/camera/internal/fisheye.h"

namespace collinea {

/// Kannala and Brandt (2006), fisheye: f times an odd polynomial of the angle, of the ninth degree. The law is g = t;
/// with k4 and without p1 and p2 the distortion makes it t (1 + k1 t^2 + k2 t^4 + k3 t^6 + k4 t^8).
struct KannalaBrandt : Fisheye<KannalaBrandt>, private CameraParameters {
  static constexpr std::string_view kName = "kannala_brandt";
  static constexpr std::array<int, 9> kHas = {kF, kCx, kCy, kK1, kK2, kK3, kB1, kB2, kK4};
  /// The focal length of a lens that shows 180 degrees from corner to corner, in diagonals of the image.
  static constexpr double kFocalPerDiagonal = 1 / std::numbers::pi;

  static FisheyeRadius radius(double angle_rad) { return {angle_rad, 1}; }
  static double angle_rad(double g) { return std::min(g, std::numbers::pi); }
  friend constexpr bool operator==(const KannalaBrandt&, const KannalaBrandt&) { return true; }
};

}  // namespace collinea
