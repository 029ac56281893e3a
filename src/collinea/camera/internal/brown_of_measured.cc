// SPDX-License-Identifier: Apache-2.0
#include "collinea/camera/internal/brown_of_measured.h"

#include <Eigen/LU>

#include "collinea/camera/internal/distortion.h"

namespace collinea {

std::optional<Eigen::Vector2d> BrownOfMeasured::project(const double* p, const Eigen::Vector3d& point_in_cam,
                                                        Matrix23* by_point, Matrix2P* by_params) {
  if (!(point_in_cam.z() > 0)) return std::nullopt;
  const double w = 1 / point_in_cam.z(), x = point_in_cam.x() * w, y = point_in_cam.y() * w;
  const distortion::Undistorted m = distortion::undistort(p, x, y);
  const distortion::Distorted d = distortion::distort(p, m.x, m.y);
  if (!m.met || d.folded || distortion::folds_before(p, m.x * m.x + m.y * m.y)) return std::nullopt;
  Eigen::Matrix2d affinity, by_measured;
  affinity << p[kF] + p[kB1], p[kB2], 0, p[kF];
  by_measured << d.dx_dx, d.dx_dy, d.dx_dy, d.dy_dy;
  const Eigen::Matrix2d by_ideal = affinity * by_measured.inverse();
  if (by_point) {
    Matrix23 ideal_by_point;
    ideal_by_point << w, 0, -x * w, 0, w, -y * w;
    *by_point = by_ideal * ideal_by_point;
  }
  if (by_params) {
    by_params->setZero();
    by_params->col(kF) << m.x, m.y;
    by_params->col(kCx) << 1, 0;
    by_params->col(kCy) << 0, 1;
    by_params->col(kB1) << m.x, 0;
    by_params->col(kB2) << m.y, 0;
    const distortion::PolynomialTerms terms = distortion::terms_of(m.x, m.y);
    for (int k = 0; k < 5; ++k) by_params->col(kK1 + k) = -(by_ideal * Eigen::Vector2d(terms.x[k], terms.y[k]));
  }
  const Eigen::Vector2d measured = affinity * Eigen::Vector2d(m.x, m.y);
  return Eigen::Vector2d(p[kCx] + measured.x(), p[kCy] + measured.y());
}

Eigen::Vector2d BrownOfMeasured::undistorted(const double* params, const Eigen::Vector2d& measured) {
  const distortion::Distorted ideal = distortion::distort(params, measured.x(), measured.y());
  return {ideal.x, ideal.y};
}

}  // namespace collinea
