// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

#include "collinea/camera/internal/distortion.h"
#include "collinea/camera/internal/fisheye.h"

namespace collinea {

template <class Law>
std::optional<Eigen::Vector2d> Fisheye<Law>::project(const double* p, const Eigen::Vector3d& point, Matrix23* by_point,
                                                     Matrix2P* by_params) {
  const double across = std::hypot(point.x(), point.y()), z = point.z(), rho2 = across * across + z * z;
  if (!(across > 0 || z > 0) || !std::isfinite(rho2)) return std::nullopt;
  const FisheyeRadius radius = Law::radius(std::atan2(across, z));
  const double scale = across > 0 ? radius.g / across : 1 / z;
  const double x = point.x() * scale, y = point.y() * scale, r2 = x * x + y * y;
  const distortion::Distorted d = distortion::distort(p, x, y);
  if (d.folded || distortion::folds_before(p, r2)) return std::nullopt;
  const double f = p[CameraParameters::kF], fx = f + p[CameraParameters::kB1], b2 = p[CameraParameters::kB2];
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
    by_params->col(CameraParameters::kF) << d.x, d.y;
    by_params->col(CameraParameters::kCx) << 1, 0;
    by_params->col(CameraParameters::kCy) << 0, 1;
    by_params->col(CameraParameters::kB1) << d.x, 0;
    by_params->col(CameraParameters::kB2) << d.y, 0;
    const distortion::PolynomialTerms terms = distortion::terms_of(x, y);
    const auto by_term = [&](double tx, double ty) { return Eigen::Vector2d(fx * tx + b2 * ty, f * ty); };
    for (int k = 0; k < 5; ++k) by_params->col(CameraParameters::kK1 + k) = by_term(terms.x[k], terms.y[k]);
    const double r8 = r2 * r2 * r2 * r2;
    by_params->col(CameraParameters::kK4) = by_term(x * r8, y * r8);
  }
  return Eigen::Vector2d(p[CameraParameters::kCx] + fx * d.x + b2 * d.y, p[CameraParameters::kCy] + f * d.y);
}

/// Where a ray of a fisheye goes: its angle from the axis, and across it.
struct FisheyeRay {
  double angle_rad;
  Eigen::Vector2d across;  // unit vector
};

template <class Law>
FisheyeRay fisheye_ray(const double* params, const Eigen::Vector2d& measured) {
  const distortion::Undistorted ideal = distortion::undistort(params, measured.x(), measured.y());
  const double g = std::hypot(ideal.x, ideal.y);
  if (!(g > 0)) return {0, {1, 0}};
  return {Law::angle_rad(g), Eigen::Vector2d(ideal.x, ideal.y) / g};
}

template <class Law>
Eigen::Vector2d Fisheye<Law>::normalized(const double* params, const Eigen::Vector2d& measured) {
  const FisheyeRay ray = fisheye_ray<Law>(params, measured);
  return std::tan(std::min(ray.angle_rad, kWidestPlane_rad)) * ray.across;
}

template <class Law>
Eigen::Vector3d Fisheye<Law>::ray(const double* params, const Eigen::Vector2d& measured) {
  const FisheyeRay ray = fisheye_ray<Law>(params, measured);
  const double sine = std::sin(ray.angle_rad);
  return {sine * ray.across.x(), sine * ray.across.y(), std::cos(ray.angle_rad)};
}

template <class Law>
bool Fisheye<Law>::in_plane(const double* params, const Eigen::Vector2d& measured) {
  return fisheye_ray<Law>(params, measured).angle_rad < kWidestPlane_rad;
}

template <class Law>
double Fisheye<Law>::pixels_per_unit(double focal_px, const Eigen::Vector2d& normalized_xy) {
  const double tangent = normalized_xy.norm(), angle_rad = std::atan(tangent);
  if (!(tangent > 1e-6)) return focal_px;
  const FisheyeRadius radius = Law::radius(angle_rad);
  const double along = radius.by_angle / (1 + tangent * tangent), across = radius.g / tangent;
  return focal_px * std::sqrt(along * across);
}

}  // namespace collinea
