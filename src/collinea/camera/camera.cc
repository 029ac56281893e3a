// SPDX-License-Identifier: Apache-2.0
#include "collinea/camera/camera.h"

#include <Eigen/LU>
#include <cmath>

namespace collinea {
namespace {

struct Distorted {
  double x, y;                 // xd, yd
  double dx_dx, dx_dy, dy_dy;  // the Jacobian; it is symmetric: d(xd)/dy = d(yd)/dx
  bool folded;                 // beyond the radius where the radial polynomial stops growing
};

Distorted distort(const Camera& camera, double x, double y) {
  const auto& p = camera.params;
  const double k1 = p[Camera::kK1], k2 = p[Camera::kK2], k3 = p[Camera::kK3], p1 = p[Camera::kP1], p2 = p[Camera::kP2];
  const double r2 = x * x + y * y;
  const double radial = r2 * (k1 + r2 * (k2 + r2 * k3));
  const double radial_by_r2 = k1 + r2 * (2 * k2 + r2 * 3 * k3);
  Distorted d;
  d.x = x + x * radial + p1 * (r2 + 2 * x * x) + 2 * p2 * x * y;
  d.y = y + y * radial + p2 * (r2 + 2 * y * y) + 2 * p1 * x * y;
  d.dx_dx = 1 + radial + 2 * x * x * radial_by_r2 + 6 * p1 * x + 2 * p2 * y;
  d.dx_dy = 2 * x * y * radial_by_r2 + 2 * p1 * y + 2 * p2 * x;
  d.dy_dy = 1 + radial + 2 * y * y * radial_by_r2 + 6 * p2 * y + 2 * p1 * x;
  d.folded = !(1 + radial + 2 * r2 * radial_by_r2 > 0);
  return d;
}

// The polynomial may fold outside the picture and grow again further out; a point is seen only on the inner branch.
bool folds_before(const Camera& camera, double r2) {
  const double k1 = camera.params[Camera::kK1], k2 = camera.params[Camera::kK2], k3 = camera.params[Camera::kK3];
  if (k1 >= 0 && k2 >= 0 && k3 >= 0) return false;
  constexpr int kSteps = 8;
  for (int i = 1; i <= kSteps; ++i) {
    const double s = r2 * i / kSteps;
    if (!(1 + s * (3 * k1 + s * (5 * k2 + s * 7 * k3)) > 0)) return true;
  }
  return false;
}

// Where D meets (xd, yd), by damped Newton iteration; `met` tells whether it did, to rounding.
struct Undistorted {
  double x, y;
  bool met;
};

Undistorted undistort(const Camera& camera, double xd, double yd) {
  double x = xd, y = yd;
  bool met = false;
  for (int iteration = 0; iteration < 20; ++iteration) {
    const Distorted d = distort(camera, x, y);
    const double ex = xd - d.x, ey = yd - d.y;
    const double determinant = d.dx_dx * d.dy_dy - d.dx_dy * d.dx_dy;
    if (d.folded || !(determinant > 1e-3)) {  // damp: walk back towards the centre
      x *= 0.8;
      y *= 0.8;
      continue;
    }
    const double step_x = (d.dy_dy * ex - d.dx_dy * ey) / determinant;
    const double step_y = (d.dx_dx * ey - d.dx_dy * ex) / determinant;
    x += step_x;
    y += step_y;
    const double step = std::abs(step_x) + std::abs(step_y);
    met = step < 1e-12;
    if (step < 1e-14) break;
  }
  return {x, y, met};
}

struct PolynomialTerms {
  double x[5], y[5];  // D by k1, k2, k3, p1, p2
};

PolynomialTerms terms_of(double x, double y) {
  const double r2 = x * x + y * y, r4 = r2 * r2, r6 = r4 * r2, xy2 = 2 * x * y;
  return {{x * r2, x * r4, x * r6, r2 + 2 * x * x, xy2}, {y * r2, y * r4, y * r6, xy2, r2 + 2 * y * y}};
}

// project() of a lens whose polynomial corrects measured coordinates.
std::optional<Eigen::Vector2d> project_to_measured(const Camera& camera, const Eigen::Vector3d& point_in_cam,
                                                   Matrix23* by_point, Matrix2P* by_params) {
  const double w = 1 / point_in_cam.z(), x = point_in_cam.x() * w, y = point_in_cam.y() * w;
  const Undistorted m = undistort(camera, x, y);
  const Distorted d = distort(camera, m.x, m.y);
  if (!m.met || d.folded || folds_before(camera, m.x * m.x + m.y * m.y)) return std::nullopt;
  const auto& p = camera.params;
  Eigen::Matrix2d affinity, by_measured;
  affinity << p[Camera::kF] + p[Camera::kB1], p[Camera::kB2], 0, p[Camera::kF];
  by_measured << d.dx_dx, d.dx_dy, d.dx_dy, d.dy_dy;
  const Eigen::Matrix2d by_ideal = affinity * by_measured.inverse();
  if (by_point) {
    Matrix23 ideal_by_point;
    ideal_by_point << w, 0, -x * w, 0, w, -y * w;
    *by_point = by_ideal * ideal_by_point;
  }
  if (by_params) {
    by_params->setZero();
    by_params->col(Camera::kF) << m.x, m.y;
    by_params->col(Camera::kCx) << 1, 0;
    by_params->col(Camera::kCy) << 0, 1;
    by_params->col(Camera::kB1) << m.x, 0;
    by_params->col(Camera::kB2) << m.y, 0;
    const PolynomialTerms terms = terms_of(m.x, m.y);
    for (int k = 0; k < 5; ++k)
      by_params->col(Camera::kK1 + k) = -(by_ideal * Eigen::Vector2d(terms.x[k], terms.y[k]));
  }
  const Eigen::Vector2d measured = affinity * Eigen::Vector2d(m.x, m.y);
  return Eigen::Vector2d(p[Camera::kCx] + measured.x(), p[Camera::kCy] + measured.y());
}

}  // namespace

Camera ideal_camera(double focal_px, int width_px, int height_px) {
  Camera camera;
  camera.params[Camera::kF] = focal_px;
  camera.params[Camera::kCx] = width_px / 2.0;
  camera.params[Camera::kCy] = height_px / 2.0;
  camera.width_px = width_px;
  camera.height_px = height_px;
  return camera;
}

std::optional<Eigen::Vector2d> project(const Camera& camera, const Eigen::Vector3d& point_in_cam) {
  return project(camera, point_in_cam, nullptr, nullptr);
}

std::optional<Eigen::Vector2d> project(const Camera& camera, const Eigen::Vector3d& point_in_cam, Matrix23* by_point,
                                       Matrix2P* by_params) {
  if (!(point_in_cam.z() > 0)) return std::nullopt;
  if (camera.model == CameraModel::kBrownOfMeasured)
    return project_to_measured(camera, point_in_cam, by_point, by_params);
  const double w = 1 / point_in_cam.z(), x = point_in_cam.x() * w, y = point_in_cam.y() * w;
  const double r2 = x * x + y * y;
  const Distorted d = distort(camera, x, y);
  if (d.folded || folds_before(camera, r2)) return std::nullopt;
  const auto& p = camera.params;
  const double f = p[Camera::kF], fx = f + p[Camera::kB1], b2 = p[Camera::kB2];

  if (by_point) {
    const double col_dx = fx * d.dx_dx + b2 * d.dx_dy, col_dy = fx * d.dx_dy + b2 * d.dy_dy;
    const double row_dx = f * d.dx_dy, row_dy = f * d.dy_dy;
    *by_point << col_dx * w, col_dy * w, -(col_dx * x + col_dy * y) * w,  //
        row_dx * w, row_dy * w, -(row_dx * x + row_dy * y) * w;
  }
  if (by_params) {
    const double r4 = r2 * r2, r6 = r4 * r2;
    const double xp1 = r2 + 2 * x * x, xp2 = 2 * x * y, yp2 = r2 + 2 * y * y;
    by_params->row(0) << d.x, 1, 0, fx * x * r2 + b2 * y * r2, fx * x * r4 + b2 * y * r4, fx * x * r6 + b2 * y * r6,
        fx * xp1 + b2 * xp2, fx * xp2 + b2 * yp2, d.x, d.y;
    by_params->row(1) << d.y, 0, 1, f * y * r2, f * y * r4, f * y * r6, f * xp2, f * yp2, 0, 0;
  }
  return Eigen::Vector2d(p[Camera::kCx] + fx * d.x + b2 * d.y, p[Camera::kCy] + f * d.y);
}

Eigen::Vector2d normalized(const Camera& camera, const Eigen::Vector2d& pixel) {
  const auto& p = camera.params;
  const double yd = (pixel.y() - p[Camera::kCy]) / p[Camera::kF];
  const double xd = (pixel.x() - p[Camera::kCx] - p[Camera::kB2] * yd) / (p[Camera::kF] + p[Camera::kB1]);
  if (camera.model == CameraModel::kBrownOfMeasured) {
    const Distorted ideal = distort(camera, xd, yd);
    return {ideal.x, ideal.y};
  }
  const Undistorted ideal = undistort(camera, xd, yd);
  return {ideal.x, ideal.y};
}

Eigen::Vector3d ray_in_cam(const Camera& camera, const Eigen::Vector2d& pixel) {
  const Eigen::Vector2d direction = normalized(camera, pixel);
  return Eigen::Vector3d(direction.x(), direction.y(), 1).normalized();
}

}  // namespace collinea
