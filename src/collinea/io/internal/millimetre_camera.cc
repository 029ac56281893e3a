// SPDX-License-Identifier: Apache-2.0
#include "collinea/io/internal/millimetre_camera.h"

namespace collinea {

Camera camera_of(const MillimetreCamera& mm) {
  Camera camera;
  camera.model = mm.forward ? CameraModel(Brown{}) : BrownOfMeasured{};
  camera.width_px = mm.width_px;
  camera.height_px = mm.height_px;
  const double c = mm.focal_mm, c2 = c * c, sign = mm.forward ? -1 : 1;
  auto& p = camera.params;
  p[Camera::kF] = c / mm.pixel_height_mm;
  p[Camera::kB1] = p[Camera::kF] * (1 / (1 + mm.off_aspect) - 1);
  p[Camera::kB2] = p[Camera::kF] * mm.skew / (1 + mm.off_aspect);
  p[Camera::kCx] = mm.principal_mm[0] / mm.pixel_height_mm;
  p[Camera::kCy] = mm.principal_mm[1] / mm.pixel_height_mm;
  p[Camera::kK1] = sign * mm.k[0] * c2;
  p[Camera::kK2] = sign * mm.k[1] * c2 * c2;
  p[Camera::kK3] = sign * mm.k[2] * c2 * c2 * c2;
  p[Camera::kP1] = sign * mm.p[0] * c;
  p[Camera::kP2] = -sign * mm.p[1] * c;  // y points the other way
  for (double& value : p) value += 0.0;  // no minus in front of nought
  return camera;
}

MillimetreCamera millimetre_camera(const Camera& camera, double pixel_height_mm) {
  const auto& p = camera.params;
  MillimetreCamera mm;
  mm.forward = is<Brown>(camera.model);
  mm.width_px = camera.width_px;
  mm.height_px = camera.height_px;
  mm.pixel_height_mm = pixel_height_mm;
  mm.focal_mm = p[Camera::kF] * pixel_height_mm;
  mm.off_aspect = -p[Camera::kB1] / (p[Camera::kF] + p[Camera::kB1]);
  mm.skew = p[Camera::kB2] / (p[Camera::kF] + p[Camera::kB1]);
  mm.principal_mm = {p[Camera::kCx] * pixel_height_mm, p[Camera::kCy] * pixel_height_mm};
  const double c = mm.focal_mm, c2 = c * c, sign = mm.forward ? -1 : 1;
  mm.k = {sign * p[Camera::kK1] / c2, sign * p[Camera::kK2] / (c2 * c2), sign * p[Camera::kK3] / (c2 * c2 * c2)};
  mm.p = {sign * p[Camera::kP1] / c, -sign * p[Camera::kP2] / c};
  return mm;
}

}  // namespace collinea
