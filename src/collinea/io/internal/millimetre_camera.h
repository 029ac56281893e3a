// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "collinea/camera/camera.h"

namespace collinea {

/// A camera as PhotoModeler and DBAT write it: image coordinates in millimetres from the principal point, x right and y
/// up, and a lens that corrects measured coordinates:
///     y = py - row * pixel_height, x = (column * pixel_height - px) (1 + off_aspect) + skew y
///     x + x (k1 r^2 + k2 r^4 + k3 r^6) + p1 (r^2 + 2 x^2) + 2 p2 x y = -focal X / Z, and so for y
/// `forward`: the lens distorts instead, with the same signs: the polynomial is taken off -focal X / Z.
struct MillimetreCamera {
  int width_px = 0, height_px = 0;
  double pixel_height_mm = 0;
  double off_aspect = 0;  ///< width of a pixel over its height, less 1
  double focal_mm = 0;
  std::array<double, 2> principal_mm{};
  std::array<double, 3> k{};  ///< [mm^-2, mm^-4, mm^-6]
  std::array<double, 2> p{};  ///< [mm^-1]
  bool forward = false;
  double skew = 0;  ///< shear of the columns
};

/// The same camera in pixels. Pixels are counted as they were: their origin stays where the other program has it.
[[nodiscard]] Camera camera_of(const MillimetreCamera& camera);

/// The inverse, for that height of a pixel.
[[nodiscard]] MillimetreCamera millimetre_camera(const Camera& camera, double pixel_height_mm);

}  // namespace collinea
