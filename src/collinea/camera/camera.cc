// SPDX-License-Identifier: Apache-2.0
#include "collinea/camera/camera.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "collinea/base/result.h"
#include "collinea/camera/core.h"

namespace collinea {
namespace {

struct Distorted {
  double x, y;                 // xd, yd
  double dx_dx, dx_dy, dy_dy;  // the Jacobian; it is symmetric: d(xd)/dy = d(yd)/dx
  bool folded;                 // beyond the radius where the radial polynomial stops growing
};

Distorted distort(const double* p, double x, double y) {
  const double k1 = p[Camera::kK1], k2 = p[Camera::kK2], k3 = p[Camera::kK3], p1 = p[Camera::kP1], p2 = p[Camera::kP2];
  const double k4 = p[Camera::kK4];
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

// The polynomial may fold outside the picture and grow again further out; a point is seen only on the inner branch.
bool folds_before(const double* p, double r2) {
  const double k1 = p[Camera::kK1], k2 = p[Camera::kK2], k3 = p[Camera::kK3], k4 = p[Camera::kK4];
  if (k1 >= 0 && k2 >= 0 && k3 >= 0 && k4 >= 0) return false;
  constexpr int kSteps = 8;
  for (int i = 1; i <= kSteps; ++i) {
    const double s = r2 * i / kSteps;
    if (!(1 + s * (3 * k1 + s * (5 * k2 + s * 7 * k3 + s * s * 9 * k4)) > 0)) return true;
  }
  return false;
}

// Where D meets (xd, yd), by damped Newton iteration; `met` tells whether it did, to rounding.
struct Undistorted {
  double x, y;
  bool met;
};

Undistorted undistort(const double* params, double xd, double yd) {
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

struct PolynomialTerms {
  double x[5], y[5];  // D by k1, k2, k3, p1, p2
};

PolynomialTerms terms_of(double x, double y) {
  const double r2 = x * x + y * y, r4 = r2 * r2, r6 = r4 * r2, xy2 = 2 * x * y;
  return {{x * r2, x * r4, x * r6, r2 + 2 * x * x, xy2}, {y * r2, y * r4, y * r6, xy2, r2 + 2 * y * y}};
}

// project() of a lens whose polynomial corrects measured coordinates.
std::optional<Eigen::Vector2d> project_to_measured(const double* p, const Eigen::Vector3d& point_in_cam,
                                                   Matrix23* by_point, Matrix2P* by_params) {
  const double w = 1 / point_in_cam.z(), x = point_in_cam.x() * w, y = point_in_cam.y() * w;
  const Undistorted m = undistort(p, x, y);
  const Distorted d = distort(p, m.x, m.y);
  if (!m.met || d.folded || folds_before(p, m.x * m.x + m.y * m.y)) return std::nullopt;
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
    for (int k = 0; k < 5; ++k) by_params->col(Camera::kK1 + k) = -(by_ideal * Eigen::Vector2d(terms.x[k], terms.y[k]));
  }
  const Eigen::Vector2d measured = affinity * Eigen::Vector2d(m.x, m.y);
  return Eigen::Vector2d(p[Camera::kCx] + measured.x(), p[Camera::kCy] + measured.y());
}

// How far from the axis a direction is seen by a fisheye without distortion, in focal lengths, and its derivative.
struct Radius {
  double g, by_angle;
};

Radius fisheye_radius(CameraModel model, double angle_rad) {
  if (model == CameraModel::kEquisolid) return {2 * std::sin(angle_rad / 2), std::cos(angle_rad / 2)};
  return {angle_rad, 1};
}

double fisheye_angle_rad(CameraModel model, double g) {
  if (model == CameraModel::kEquisolid) return 2 * std::asin(std::min(1.0, g / 2));
  return std::min(g, std::numbers::pi);
}

// project() of a fisheye.
std::optional<Eigen::Vector2d> project_to_fisheye(const CameraCore& camera, const Eigen::Vector3d& point,
                                                  Matrix23* by_point, Matrix2P* by_params) {
  const double* p = camera.params;
  const double across = std::hypot(point.x(), point.y()), z = point.z(), rho2 = across * across + z * z;
  if (!(across > 0 || z > 0) || !std::isfinite(rho2)) return std::nullopt;
  const Radius radius = fisheye_radius(camera.model, std::atan2(across, z));
  const double scale = across > 0 ? radius.g / across : 1 / z;
  const double x = point.x() * scale, y = point.y() * scale, r2 = x * x + y * y;
  const Distorted d = distort(p, x, y);
  if (d.folded || folds_before(p, r2)) return std::nullopt;
  const double f = p[Camera::kF], fx = f + p[Camera::kB1], b2 = p[Camera::kB2];
  if (by_point) {
    const double ux = across > 0 ? point.x() / across : 1, uy = across > 0 ? point.y() / across : 0;
    const double along = radius.by_angle * z / rho2, out = -radius.by_angle / rho2;
    Matrix23 ideal;
    ideal << scale + ux * ux * (along - scale), ux * uy * (along - scale), point.x() * out,  //
        ux * uy * (along - scale), scale + uy * uy * (along - scale), point.y() * out;
    Eigen::Matrix2d by_ideal;
    by_ideal << fx * d.dx_dx + b2 * d.dx_dy, fx * d.dx_dy + b2 * d.dy_dy, f * d.dx_dy, f * d.dy_dy;
    *by_point = by_ideal * ideal;
  }
  if (by_params) {
    by_params->setZero();
    by_params->col(Camera::kF) << d.x, d.y;
    by_params->col(Camera::kCx) << 1, 0;
    by_params->col(Camera::kCy) << 0, 1;
    by_params->col(Camera::kB1) << d.x, 0;
    by_params->col(Camera::kB2) << d.y, 0;
    const PolynomialTerms terms = terms_of(x, y);
    const auto by_term = [&](double tx, double ty) { return Eigen::Vector2d(fx * tx + b2 * ty, f * ty); };
    for (int k = 0; k < 5; ++k) by_params->col(Camera::kK1 + k) = by_term(terms.x[k], terms.y[k]);
    const double r8 = r2 * r2 * r2 * r2;
    by_params->col(Camera::kK4) = by_term(x * r8, y * r8);
  }
  return Eigen::Vector2d(p[Camera::kCx] + fx * d.x + b2 * d.y, p[Camera::kCy] + f * d.y);
}

std::optional<Eigen::Vector2d> project_brown(const double* p, const Eigen::Vector3d& point_in_cam, Matrix23* by_point,
                                             Matrix2P* by_params) {
  const double w = 1 / point_in_cam.z(), x = point_in_cam.x() * w, y = point_in_cam.y() * w;
  const double r2 = x * x + y * y;
  const Distorted d = distort(p, x, y);
  if (d.folded || folds_before(p, r2)) return std::nullopt;
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
    by_params->setZero();
    by_params->row(0).head<10>() << d.x, 1, 0, fx * x * r2 + b2 * y * r2, fx * x * r4 + b2 * y * r4,
        fx * x * r6 + b2 * y * r6, fx * xp1 + b2 * xp2, fx * xp2 + b2 * yp2, d.x, d.y;
    by_params->row(1).head<10>() << d.y, 0, 1, f * y * r2, f * y * r4, f * y * r6, f * xp2, f * yp2, 0, 0;
  }
  return Eigen::Vector2d(p[Camera::kCx] + fx * d.x + b2 * d.y, p[Camera::kCy] + f * d.y);
}

std::optional<Eigen::Vector2d> project_without_additional(const CameraCore& camera, const Eigen::Vector3d& point_in_cam,
                                                          Matrix23* by_point, Matrix2P* by_params) {
  if (is_fisheye(camera.model)) return project_to_fisheye(camera, point_in_cam, by_point, by_params);
  if (!(point_in_cam.z() > 0)) return std::nullopt;
  if (camera.model == CameraModel::kBrownOfMeasured)
    return project_to_measured(camera.params, point_in_cam, by_point, by_params);
  return project_brown(camera.params, point_in_cam, by_point, by_params);
}

const double* additional_of(const CameraCore& camera) { return camera.params + Camera::kParams; }

// The pixel before the additional shift, by Newton iteration from where it was measured: the shift is small and smooth.
Eigen::Vector2d without_additional(const CameraCore& camera, const Eigen::Vector2d& pixel) {
  Eigen::Vector2d at = pixel;
  for (int iteration = 0; iteration < 10; ++iteration) {
    const AdditionalShift shift = additional_shift(camera.additional, additional_of(camera), camera.size, at);
    const Eigen::Matrix2d by_pixel = Eigen::Matrix2d::Identity() + shift.by_pixel;
    if (!(by_pixel.determinant() > 1e-3)) break;
    const Eigen::Vector2d step = by_pixel.inverse() * (pixel - at - shift.shift_px);
    at += step;
    if (step.norm() < 1e-12 * (1 + pixel.norm())) break;
  }
  return at;
}

// The place in the picture in focal lengths from the principal point, before D is undone.
Eigen::Vector2d distorted_place(const Camera& camera, Eigen::Vector2d pixel) {
  if (camera.additional != AdditionalSet::kNone) [[unlikely]]
    pixel = without_additional(core_of(camera), pixel);
  const auto& p = camera.params;
  const double yd = (pixel.y() - p[Camera::kCy]) / p[Camera::kF];
  const double xd = (pixel.x() - p[Camera::kCx] - p[Camera::kB2] * yd) / (p[Camera::kF] + p[Camera::kB1]);
  return {xd, yd};
}

// Where a ray of a fisheye goes: its angle from the axis, and across it.
struct FisheyeRay {
  double angle_rad;
  Eigen::Vector2d across;  // unit vector
};

FisheyeRay fisheye_ray(const Camera& camera, const Eigen::Vector2d& pixel) {
  const Eigen::Vector2d place = distorted_place(camera, pixel);
  const Undistorted ideal = undistort(camera.params.data(), place.x(), place.y());
  const double g = std::hypot(ideal.x, ideal.y);
  if (!(g > 0)) return {0, {1, 0}};
  return {fisheye_angle_rad(camera.model, g), Eigen::Vector2d(ideal.x, ideal.y) / g};
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

std::vector<int> params_of(const Camera& camera) {
  std::vector<int> list;
  for (int k = 0; k < Camera::kParams; ++k) {
    const bool of_kannala = camera.model == CameraModel::kKannalaBrandt;
    if (k == Camera::kK4 && !of_kannala) continue;
    if ((k == Camera::kP1 || k == Camera::kP2) && of_kannala) continue;
    list.push_back(k);
  }
  for (int k = 0; k < static_cast<int>(count_of(camera.additional)); ++k) list.push_back(Camera::kParams + k);
  return list;
}

std::string param_name(int param) {
  COLLINEA_CHECK(param >= 0 && param < Camera::kAllParams);
  if (param >= Camera::kParams) return "a" + std::to_string(param - Camera::kParams + 1);
  return std::string(Camera::kParamNames[static_cast<std::size_t>(param)]);
}

std::string_view param_unit(int param) {
  return param >= Camera::kParams ? "px" : Camera::kParamUnits[static_cast<std::size_t>(param)];
}

std::optional<int> param_named(const Camera& camera, std::string_view name) {
  for (const int k : params_of(camera))
    if (param_name(k) == name) return k;
  return std::nullopt;
}

void scale_params(Camera& camera, double times) {
  for (int k = 0; k < Camera::kAllParams; ++k)
    if (param_unit(k) == "px") camera.params[static_cast<std::size_t>(k)] *= times;
}

std::optional<Eigen::Vector2d> project(const Camera& camera, const Eigen::Vector3d& point_in_cam) {
  return project(core_of(camera), point_in_cam, nullptr, nullptr);
}

std::optional<Eigen::Vector2d> project(const Camera& camera, const Eigen::Vector3d& point_in_cam, Matrix23* by_point,
                                       Matrix2P* by_params) {
  return project(core_of(camera), point_in_cam, by_point, by_params);
}

std::optional<Eigen::Vector2d> project(const CameraCore& camera, const Eigen::Vector3d& point_in_cam,
                                       Matrix23* by_point, Matrix2P* by_params) {
  const auto pixel = project_without_additional(camera, point_in_cam, by_point, by_params);
  if (camera.additional == AdditionalSet::kNone || !pixel) [[likely]]
    return pixel;
  const AdditionalShift shift = additional_shift(camera.additional, additional_of(camera), camera.size, *pixel);
  const Eigen::Matrix2d by_pixel = Eigen::Matrix2d::Identity() + shift.by_pixel;
  if (by_point) *by_point = by_pixel * *by_point;
  if (by_params) {
    *by_params = by_pixel * *by_params;
    AdditionalEffect effect;
    additional_effect(camera.additional, camera.size, *pixel, effect);
    for (std::size_t k = 0; k < count_of(camera.additional); ++k)
      by_params->col(Camera::kParams + static_cast<int>(k)) << effect.column[k], effect.row[k];
  }
  return *pixel + shift.shift_px;
}

Eigen::Vector2d normalized(const Camera& camera, const Eigen::Vector2d& pixel) {
  if (is_fisheye(camera.model)) {
    const FisheyeRay ray = fisheye_ray(camera, pixel);
    return std::tan(std::min(ray.angle_rad, kWidestPlane_rad)) * ray.across;
  }
  const Eigen::Vector2d place = distorted_place(camera, pixel);
  if (camera.model == CameraModel::kBrownOfMeasured) {
    const Distorted ideal = distort(camera.params.data(), place.x(), place.y());
    return {ideal.x, ideal.y};
  }
  const Undistorted ideal = undistort(camera.params.data(), place.x(), place.y());
  return {ideal.x, ideal.y};
}

Eigen::Vector2d without_additional(const Camera& camera, const Eigen::Vector2d& pixel) {
  return camera.additional == AdditionalSet::kNone ? pixel : without_additional(core_of(camera), pixel);
}

bool in_plane(const Camera& camera, const Eigen::Vector2d& pixel) {
  return !is_fisheye(camera.model) || fisheye_ray(camera, pixel).angle_rad < kWidestPlane_rad;
}

double pixels_per_unit(const Camera& camera, const Eigen::Vector2d& normalized_xy) {
  if (!is_fisheye(camera.model)) return camera.focal_px();
  const double tangent = normalized_xy.norm(), angle_rad = std::atan(tangent);
  if (!(tangent > 1e-6)) return camera.focal_px();
  const Radius radius = fisheye_radius(camera.model, angle_rad);
  const double along = radius.by_angle / (1 + tangent * tangent), across = radius.g / tangent;
  return camera.focal_px() * std::sqrt(along * across);
}

Eigen::Vector3d ray_in_cam(const Camera& camera, const Eigen::Vector2d& pixel) {
  if (is_fisheye(camera.model)) {
    const FisheyeRay ray = fisheye_ray(camera, pixel);
    const double sine = std::sin(ray.angle_rad);
    return {sine * ray.across.x(), sine * ray.across.y(), std::cos(ray.angle_rad)};
  }
  const Eigen::Vector2d direction = normalized(camera, pixel);
  return Eigen::Vector3d(direction.x(), direction.y(), 1).normalized();
}

}  // namespace collinea
