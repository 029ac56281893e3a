// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/internal/lens.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace collinea::bundle {
namespace {

// The smallest positive zero of d(r radial(r^2))/dr as a function of s = r^2, found by walking and halving.
double first_fold(double k1, double k2, double k3) {
  constexpr double kStep = 0.02, kWidest = 8;  // r^2 = 8: 141 degrees field of view
  const auto growth = [&](double s) { return 1 + s * (3 * k1 + s * (5 * k2 + s * 7 * k3)); };
  if (k1 >= 0 && k2 >= 0 && k3 >= 0) return std::numeric_limits<double>::infinity();
  double low = 0;
  while (low < kWidest && growth(low + kStep) > 0) low += kStep;
  if (low >= kWidest) return std::numeric_limits<double>::infinity();
  double high = low + kStep;
  for (int i = 0; i < 40; ++i) {
    const double middle = (low + high) / 2;
    (growth(middle) > 0 ? low : high) = middle;
  }
  return low;
}

struct Correction {
  double x, y;                 // D of measured coordinates
  double dx_dx, dx_dy, dy_dy;  // its derivatives; dy_dx = dx_dy
};

Correction corrected(const Lens& lens, double x, double y) {
  const double r2 = x * x + y * y;
  const double radial = 1 + r2 * (lens.k1 + r2 * (lens.k2 + r2 * lens.k3));
  const double by_r2 = 2 * (lens.k1 + r2 * (2 * lens.k2 + r2 * 3 * lens.k3));
  return {x * radial + lens.p1 * (r2 + 2 * x * x) + 2 * lens.p2 * x * y,
          y * radial + lens.p2 * (r2 + 2 * y * y) + 2 * lens.p1 * x * y,
          radial + x * x * by_r2 + 6 * lens.p1 * x + 2 * lens.p2 * y, x * y * by_r2 + 2 * lens.p1 * y + 2 * lens.p2 * x,
          radial + y * y * by_r2 + 6 * lens.p2 * y + 2 * lens.p1 * x};
}

// Newton iteration from where it was measured, which is near. False when it ends nowhere or beyond the fold.
bool find_measured(const Lens& lens, double x, double y, double* mx, double* my) {
  for (int iteration = 0; iteration < 20; ++iteration) {
    if (!(*mx * *mx + *my * *my < lens.fold_r2)) return false;
    const Correction d = corrected(lens, *mx, *my);
    const double determinant = d.dx_dx * d.dy_dy - d.dx_dy * d.dx_dy;
    if (!(determinant > 1e-3)) return false;
    const double ex = x - d.x, ey = y - d.y;
    const double step_x = (d.dy_dy * ex - d.dx_dy * ey) / determinant;
    const double step_y = (d.dx_dx * ey - d.dx_dy * ex) / determinant;
    *mx += step_x;
    *my += step_y;
    if (std::abs(step_x) + std::abs(step_y) < 1e-13) return *mx * *mx + *my * *my < lens.fold_r2;
  }
  return false;
}

// Derivatives by X/Z and Y/Z, 2 x 2 by rows, of the pixel where the point is seen: the affinity times D' inverted.
void measured_by_ideal(const Lens& lens, const Projected& at, double* d) {
  const Correction c = corrected(lens, at.xd, at.yd);
  const double determinant = c.dx_dx * c.dy_dy - c.dx_dy * c.dx_dy;
  const double mx_x = c.dy_dy / determinant, m_xy = -c.dx_dy / determinant, my_y = c.dx_dx / determinant;
  d[0] = lens.fx * mx_x + lens.b2 * m_xy;
  d[1] = lens.fx * m_xy + lens.b2 * my_y;
  d[2] = lens.f * m_xy;
  d[3] = lens.f * my_y;
}

CameraCore core_of(const Lens& lens) { return {lens.params.data(), lens.model, lens.additional, lens.size}; }

}  // namespace

bool project_other(const Lens& lens, const double* point_in_cam, const double* measured_pixel, Projected* out) {
  if (lens.kind == LensKind::kGeneral) {
    const auto pixel =
        collinea::project(core_of(lens), {point_in_cam[0], point_in_cam[1], point_in_cam[2]}, nullptr, nullptr);
    if (!pixel) return false;
    *out = {{pixel->x(), pixel->y()}, point_in_cam[0], point_in_cam[1], point_in_cam[2], 0, 0};
    return true;
  }
  if (!(point_in_cam[2] > 0)) return false;
  const double w = 1 / point_in_cam[2];
  out->x = point_in_cam[0] * w;
  out->y = point_in_cam[1] * w;
  out->r2 = out->x * out->x + out->y * out->y;
  out->yd = (measured_pixel[1] - lens.cy) / lens.f;
  out->xd = (measured_pixel[0] - lens.cx - lens.b2 * out->yd) / lens.fx;
  if (lens.kind == LensKind::kMeasured) {
    if (!find_measured(lens, out->x, out->y, &out->xd, &out->yd)) return false;
    out->pixel[0] = lens.cx + lens.fx * out->xd + lens.b2 * out->yd;
    out->pixel[1] = lens.cy + lens.f * out->yd;
    return true;
  }
  if (!(out->xd * out->xd + out->yd * out->yd < lens.fold_r2)) return false;
  const Correction c = corrected(lens, out->xd, out->yd);
  out->pixel[0] = measured_pixel[0] - lens.f * (c.x - out->x);
  out->pixel[1] = measured_pixel[1] - lens.f * (c.y - out->y);
  return true;
}

void derive_other_by_point(const Lens& lens, const Projected& at, double z, double* by_point) {
  if (lens.kind == LensKind::kGeneral) {
    Matrix23 derivatives = Matrix23::Zero();
    (void)collinea::project(core_of(lens), {at.x, at.y, z}, &derivatives, nullptr);  // what is projected is there
    for (int k = 0; k < 6; ++k) by_point[k] = derivatives(k / 3, k % 3);
    return;
  }
  double d[4] = {lens.f, 0, 0, lens.f};
  if (lens.kind == LensKind::kMeasured) measured_by_ideal(lens, at, d);
  for (int row = 0; row < 2; ++row) {
    const double dx = d[2 * row] / z, dy = d[2 * row + 1] / z;
    by_point[3 * row] = dx;
    by_point[3 * row + 1] = dy;
    by_point[3 * row + 2] = -(dx * at.x + dy * at.y);
  }
}

void derive_other_by_params(const Lens& lens, const Projected& at, double* by_params) {
  double* column = by_params;
  double* row = by_params + Camera::kAllParams;
  if (lens.kind == LensKind::kGeneral) {
    Matrix2P derivatives = Matrix2P::Zero();
    Matrix23 by_point;
    (void)collinea::project(core_of(lens), {at.x, at.y, at.r2}, &by_point, &derivatives);
    for (int k = 0; k < Camera::kAllParams; ++k) column[k] = derivatives(0, k), row[k] = derivatives(1, k);
    return;
  }
  for (int k = 0; k < 2 * Camera::kAllParams; ++k) by_params[k] = 0;
  const double x = at.xd, y = at.yd, r2 = x * x + y * y, r4 = r2 * r2, r6 = r4 * r2, xy2 = 2 * x * y;
  const double polynomial[5][2] = {
      {x * r2, y * r2}, {x * r4, y * r4}, {x * r6, y * r6}, {r2 + 2 * x * x, xy2}, {xy2, r2 + 2 * y * y}};
  if (lens.kind == LensKind::kMeasured) {
    double d[4];
    measured_by_ideal(lens, at, d);
    column[Camera::kF] = x, row[Camera::kF] = y;
    column[Camera::kCx] = 1, row[Camera::kCy] = 1;
    column[Camera::kB1] = x, column[Camera::kB2] = y;
    for (int k = 0; k < 5; ++k) {
      column[Camera::kK1 + k] = -(d[0] * polynomial[k][0] + d[1] * polynomial[k][1]);
      row[Camera::kK1 + k] = -(d[2] * polynomial[k][0] + d[3] * polynomial[k][1]);
    }
    return;
  }
  // Minus the derivatives of f (D(xd, yd) - (x, y)), where xd and yd are those of the measured pixel.
  const Correction c = corrected(lens, x, y);
  const auto by_measured = [&](int param, double dx, double dy) {
    column[param] -= lens.f * (c.dx_dx * dx + c.dx_dy * dy);
    row[param] -= lens.f * (c.dx_dy * dx + c.dy_dy * dy);
  };
  column[Camera::kF] = at.x - c.x;
  row[Camera::kF] = at.y - c.y;
  by_measured(Camera::kF, (lens.b2 * y / lens.f - x) / lens.fx, -y / lens.f);
  by_measured(Camera::kCx, -1 / lens.fx, 0);
  by_measured(Camera::kCy, lens.b2 / (lens.f * lens.fx), -1 / lens.f);
  by_measured(Camera::kB1, -x / lens.fx, 0);
  by_measured(Camera::kB2, -y / lens.fx, 0);
  for (int k = 0; k < 5; ++k) {
    column[Camera::kK1 + k] = -lens.f * polynomial[k][0];
    row[Camera::kK1 + k] = -lens.f * polynomial[k][1];
  }
}

Lens lens_with(const Lens& old, const double* params) {
  Lens lens;
  lens.f = params[Camera::kF];
  lens.fx = params[Camera::kF] + params[Camera::kB1];
  lens.b2 = params[Camera::kB2];
  lens.cx = params[Camera::kCx];
  lens.cy = params[Camera::kCy];
  lens.k1 = params[Camera::kK1];
  lens.k2 = params[Camera::kK2];
  lens.k3 = params[Camera::kK3];
  lens.p1 = params[Camera::kP1];
  lens.p2 = params[Camera::kP2];
  lens.kind = old.kind;
  lens.fold_r2 = lens.kind == LensKind::kGeneral ? 0 : first_fold(lens.k1, lens.k2, lens.k3);
  lens.max_r2 = lens.kind == LensKind::kBrown ? lens.fold_r2 : -1;
  lens.model = old.model;
  lens.additional = old.additional;
  lens.size = old.size;
  std::copy_n(params, lens.params.size(), lens.params.begin());
  return lens;
}

Lens lens_of(const Camera& camera, bool compare_corrected) {
  Lens lens;
  lens.kind = kind_of(camera, compare_corrected);
  lens.model = camera.model;
  lens.additional = camera.additional;
  lens.size = {static_cast<double>(camera.width_px), static_cast<double>(camera.height_px)};
  return lens_with(lens, camera.params.data());
}

}  // namespace collinea::bundle
