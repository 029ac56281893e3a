// SPDX-License-Identifier: Apache-2.0
#include "collinea/camera/internal/brown.h"

#include "collinea/camera/internal/distortion.h"

namespace collinea {

std::optional<Eigen::Vector2d> Brown::project(const double* p, const Eigen::Vector3d& point_in_cam, Matrix23* by_point,
                                              Matrix2P* by_params) {
  if (!(point_in_cam.z() > 0)) return std::nullopt;
  const double w = 1 / point_in_cam.z(), x = point_in_cam.x() * w, y = point_in_cam.y() * w;
  const double r2 = x * x + y * y;
  const distortion::Distorted d = distortion::distort(p, x, y);
  if (d.folded || distortion::folds_before(p, r2)) return std::nullopt;
  const double f = p[kF], fx = f + p[kB1], b2 = p[kB2];

  if (by_point) {
    const double col_dx = fx * d.dx_dx + b2 * d.dx_dy, col_dy = fx * d.dx_dy + b2 * d.dy_dy;
    const double row_dx = f * d.dx_dy, row_dy = f * d.dy_dy;
    *by_point << col_dx * w, col_dy * w, -(col_dx * x + col_dy * y) * w,  //
        row_dx * w, row_dy * w, -(row_dx * x + row_dy * y) * w;
  }
  if (by_params) {
    const double r4 = r2 * r2, r6 = r4 * r2;
    const double xp1 = r2 + 2 * x * x, xp2 = 2 * x * y, yp2 = r2 + 2 * y * y;
    by_params->setZero();
    by_params->row(0).head<10>() << d.x, 1, 0, fx * x * r2 + b2 * y * r2, fx * x * r4 + b2 * y * r4,
        fx * x * r6 + b2 * y * r6, fx * xp1 + b2 * xp2, fx * xp2 + b2 * yp2, d.x, d.y;
    by_params->row(1).head<10>() << d.y, 0, 1, f * y * r2, f * y * r4, f * y * r6, f * xp2, f * yp2, 0, 0;
  }
  return Eigen::Vector2d(p[kCx] + fx * d.x + b2 * d.y, p[kCy] + f * d.y);
}

Eigen::Vector2d Brown::undistorted(const double* params, const Eigen::Vector2d& measured) {
  const distortion::Undistorted ideal = distortion::undistort(params, measured.x(), measured.y());
  return {ideal.x, ideal.y};
}

}  // namespace collinea
