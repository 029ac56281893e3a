// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "collinea/camera/internal/parameters.h"

// The polynomial D of camera/camera.h, its derivatives, its edge and its inverse.
namespace collinea::distortion {

/// D at (x, y).
struct Distorted {
  double x, y;                 // xd, yd
  double dx_dx, dx_dy, dy_dy;  // the Jacobian; it is symmetric: d(xd)/dy = d(yd)/dx
  bool folded;                 // beyond the radius where the radial polynomial stops growing
};

inline Distorted distort(const double* p, double x, double y) {
  const double k1 = p[CameraParameters::kK1], k2 = p[CameraParameters::kK2], k3 = p[CameraParameters::kK3],
               p1 = p[CameraParameters::kP1], p2 = p[CameraParameters::kP2];
  const double k4 = p[CameraParameters::kK4];
  const double r2 = x * x + y * y;
  const double radial = r2 * (k1 + r2 * (k2 + r2 * (k3 + r2 * k4)));
  const double radial_by_r2 = k1 + r2 * (2 * k2 + r2 * 3 * k3 + r2 * r2 * 4 * k4);
  Distorted d;
  d.x = x + x * radial + p1 * (r2 + 2 * x * x) + 2 * p2 * x * y;
  d.y = y + y * radial + p2 * (r2 + 2 * y * y) + 2 * p1 * x * y;
  d.dx_dx = 1 + radial + 2 * x * x * radial_by_r2 + 6 * p1 * x + 2 * p2 * y;
  d.dx_dy = 2 * x * y * radial_by_r2 + 2 * p1 * y + 2 * p2 * x;
  d.dy_dy = 1 + radial + 2 * y * y * radial_by_r2 + 6 * p2 * y + 2 * p1 * x;
  d.folded = !(1 + radial + 2 * r2 * radial_by_r2 > 0);
  return d;
}

/// The polynomial may fold outside the image and grow again further out; a point is seen only on the inner branch.
inline bool folds_before(const double* p, double r2) {
  const double k1 = p[CameraParameters::kK1], k2 = p[CameraParameters::kK2], k3 = p[CameraParameters::kK3],
               k4 = p[CameraParameters::kK4];
  if (k1 >= 0 && k2 >= 0 && k3 >= 0 && k4 >= 0) return false;
  constexpr int kSteps = 8;
  for (int i = 1; i <= kSteps; ++i) {
    const double s = r2 * i / kSteps;
    if (!(1 + s * (3 * k1 + s * (5 * k2 + s * 7 * k3 + s * s * 9 * k4)) > 0)) return true;
  }
  return false;
}

/// Where D meets (xd, yd), by damped Newton iteration; `met` tells whether it did, to rounding.
struct Undistorted {
  double x, y;
  bool met;
};

inline Undistorted undistort(const double* params, double xd, double yd) {
  double x = xd, y = yd;
  bool met = false;
  for (int iteration = 0; iteration < 20; ++iteration) {
    const Distorted d = distort(params, x, y);
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

/// The derivatives of D by its coefficients.
struct PolynomialTerms {
  double x[5], y[5];  // D by k1, k2, k3, p1, p2
};

inline PolynomialTerms terms_of(double x, double y) {
  const double r2 = x * x + y * y, r4 = r2 * r2, r6 = r4 * r2, xy2 = 2 * x * y;
  return {{x * r2, x * r4, x * r6, r2 + 2 * x * x, xy2}, {y * r2, y * r4, y * r6, xy2, r2 + 2 * y * y}};
}

}  // namespace collinea::distortion
