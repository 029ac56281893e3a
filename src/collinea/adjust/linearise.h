// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>

#include "collinea/adjust/internal/problem.h"

namespace collinea::bundle {

/// A residual beyond any hope, given to observations whose point is not seen by its image [px].
inline constexpr double kLost_px = 100;

/// One observation at the current unknowns, everything times weight^1/2: residual = observed - computed, derivatives of
/// the computed pixel. The centre's derivative is minus by_point. The rotation is by e in the camera frame: new
/// cam_from_world = rotation_by(e) * cam_from_world.
struct LinearRay {
  double residual[2];
  double by_rotation[6];  // 2 x 3 by rows
  double by_point[6];     // 2 x 3 by rows
  double root_weight;
  double along[2];  // unit vector of the residual, when shrink > 0
  double shrink;    // by which derivatives along it are shortened for the curvature of the loss
  Projected at;
};

inline void to_camera(const Frame& frame, const double* point, double* in_cam) {
  const double x = point[0] - frame[9], y = point[1] - frame[10], z = point[2] - frame[11];
  in_cam[0] = frame[0] * x + frame[1] * y + frame[2] * z;
  in_cam[1] = frame[3] * x + frame[4] * y + frame[5] * z;
  in_cam[2] = frame[6] * x + frame[7] * y + frame[8] * z;
}

inline double lost_square(const Ray& ray) { return kLost_px * kLost_px * ray.inverse_sigma * ray.inverse_sigma; }

/// The squared residual of an observation in units of its sigma.
inline double square_of(const Ray& ray, const Frame& frame, const Lens& lens, const double* point) {
  double in_cam[3];
  Projected at;
  to_camera(frame, point, in_cam);
  if (!project(lens, in_cam, ray.pixel, &at)) return lost_square(ray);
  const double u = (ray.pixel[0] - at.pixel[0]) * ray.inverse_sigma,
               v = (ray.pixel[1] - at.pixel[1]) * ray.inverse_sigma;
  return u * u + v * v;
}

/// Takes n n^T times a part of a 2 x count matrix off it; n is the direction of the residual.
inline void shrink_along(const LinearRay& ray, double* rows, int count) {
  for (int c = 0; c < count; ++c) {
    const double along = ray.shrink * (ray.along[0] * rows[c] + ray.along[1] * rows[count + c]);
    rows[c] -= along * ray.along[0];
    rows[count + c] -= along * ray.along[1];
  }
}

/// The loss is flatter along the residual than across: shorter derivatives, longer residual, the same gradient.
inline void bend(const Loss& loss, double s, double* by_cam, LinearRay* out) {
  const double curvature = loss.curvature(s);
  if (curvature >= 1) return;
  const double root = std::sqrt(curvature), length = std::sqrt(s) * std::sqrt(loss.weight(s));
  out->shrink = 1 - root;
  for (int c = 0; c < 2; ++c) {
    out->along[c] = out->residual[c] / length;
    out->residual[c] /= root;
  }
  shrink_along(*out, by_cam, 3);
}

/// linearise() of a lens of kBrown, or of any.
template <bool kOfBrown>
inline double linearise_as(const Ray& ray, const Frame& frame, const Lens& lens, const double* point, const Loss& loss,
                           LinearRay* out) {
  double p[3];
  to_camera(frame, point, p);
  const bool seen = kOfBrown ? project_brown(lens, p, &out->at) : project(lens, p, ray.pixel, &out->at);
  if (!seen) [[unlikely]] {
    *out = LinearRay{};
    return lost_square(ray);
  }
  double u = (ray.pixel[0] - out->at.pixel[0]) * ray.inverse_sigma;
  double v = (ray.pixel[1] - out->at.pixel[1]) * ray.inverse_sigma;
  const double s = u * u + v * v;
  const double root_rho = loss.kind == Loss::kNone ? 1 : std::sqrt(loss.weight(s));
  const double w = ray.inverse_sigma * root_rho;
  out->residual[0] = u * root_rho;
  out->residual[1] = v * root_rho;
  out->root_weight = w;
  double d[6];
  if constexpr (kOfBrown)
    derive_brown_by_point(lens, out->at, p[2], d);
  else
    derive_by_point(lens, out->at, p[2], d);
  for (double& value : d) value *= w;
  out->shrink = 0;
  if (loss.kind != Loss::kNone) bend(loss, s, d, out);
  for (int row = 0; row < 2; ++row) {
    const double* a = d + 3 * row;
    double* turn = out->by_rotation + 3 * row;  // -d [p]x
    turn[0] = a[2] * p[1] - a[1] * p[2];
    turn[1] = a[0] * p[2] - a[2] * p[0];
    turn[2] = a[1] * p[0] - a[0] * p[1];
    double* move = out->by_point + 3 * row;
    for (int c = 0; c < 3; ++c) move[c] = a[0] * frame[c] + a[1] * frame[3 + c] + a[2] * frame[6 + c];
  }
  return s;
}

double linearise_other(const Ray& ray, const Frame& frame, const Lens& lens, const double* point, const Loss& loss,
                       LinearRay* out);

/// The same with derivatives. An observation that is not seen has a square but all zero derivatives and residual.
inline double linearise(const Ray& ray, const Frame& frame, const Lens& lens, const double* point, const Loss& loss,
                        LinearRay* out) {
  if (lens.kind != LensKind::kBrown) [[unlikely]]
    return linearise_other(ray, frame, lens, point, loss, out);
  return linearise_as<true>(ray, frame, lens, point, loss, out);
}

/// Derivatives by the free parameters of the camera, times weight^1/2: 2 x free.size(), by rows.
[[gnu::always_inline]] inline void linearise_camera(const LinearRay& ray, const Lens& lens,
                                                    const std::vector<int>& free, double* by_camera) {
  const std::size_t count = free.size();
  if (ray.root_weight == 0) {
    for (std::size_t k = 0; k < 2 * count; ++k) by_camera[k] = 0;
    return;
  }
  double all[2 * Camera::kAllParams];
  derive_by_params(lens, ray.at, all);
  for (std::size_t k = 0; k < count; ++k) {
    by_camera[k] = all[free[k]] * ray.root_weight;
    by_camera[count + k] = all[Camera::kAllParams + free[k]] * ray.root_weight;
  }
  if (ray.shrink > 0) shrink_along(ray, by_camera, static_cast<int>(count));
}

/// The symmetric 3 x 3 normal matrix of a point (xx xy xz yy yz zz), its right side, and its damped Cholesky factor.
struct PointNormals {
  double v[6] = {};
  double right[3] = {};
  double l[6] = {};  // l00 l10 l11 l20 l21 l22

  void add(const LinearRay& ray) {
    const double *a = ray.by_point, *b = ray.by_point + 3, *r = ray.residual;
    v[0] += a[0] * a[0] + b[0] * b[0];
    v[1] += a[0] * a[1] + b[0] * b[1];
    v[2] += a[0] * a[2] + b[0] * b[2];
    v[3] += a[1] * a[1] + b[1] * b[1];
    v[4] += a[1] * a[2] + b[1] * b[2];
    v[5] += a[2] * a[2] + b[2] * b[2];
    for (int c = 0; c < 3; ++c) right[c] += a[c] * r[0] + b[c] * r[1];
  }
  /// The weighted coordinates of a control point; answers their cost.
  double add(const ControlCoordinates& control, const double* point) {
    constexpr int kDiagonal[3] = {0, 3, 5};
    double cost = 0;
    for (int c = 0; c < 3; ++c) {
      if (!(control.inverse_sigma[c] > 0)) continue;
      const double w = control.inverse_sigma[c], r = (control.given[c] - point[c]) * w;
      v[kDiagonal[c]] += w * w;
      right[c] += w * r;
      cost += r * r;
    }
    return control.correlated() ? cost + add_beside(control, point) : cost;
  }
  double add_beside(const ControlCoordinates& control, const double* point) {
    const double* p = control.beside;
    const double d[3] = {control.given[0] - point[0], control.given[1] - point[1], control.given[2] - point[2]};
    v[1] += p[0];
    v[2] += p[1];
    v[4] += p[2];
    right[0] += p[0] * d[1] + p[1] * d[2];
    right[1] += p[0] * d[0] + p[2] * d[2];
    right[2] += p[1] * d[0] + p[2] * d[1];
    return 2 * (p[0] * d[0] * d[1] + p[1] * d[0] * d[2] + p[2] * d[1] * d[2]);
  }
  /// Factors v + lambda diag(v). Directions that nothing fixes are held by a minute weight.
  void factor(double lambda) {
    const double floor = 1e-12 * (v[0] + v[3] + v[5]) + 1e-300;
    const double d0 = v[0] * (1 + lambda) + floor, d1 = v[3] * (1 + lambda) + floor, d2 = v[5] * (1 + lambda) + floor;
    l[0] = std::sqrt(d0);
    l[1] = v[1] / l[0];
    l[3] = v[2] / l[0];
    l[2] = std::sqrt(std::max(d1 - l[1] * l[1], floor));
    l[4] = (v[4] - l[1] * l[3]) / l[2];
    l[5] = std::sqrt(std::max(d2 - l[3] * l[3] - l[4] * l[4], floor));
  }
  /// x := L^-1 x
  void forward(double* x) const {
    x[0] /= l[0];
    x[1] = (x[1] - l[1] * x[0]) / l[2];
    x[2] = (x[2] - l[3] * x[0] - l[4] * x[1]) / l[5];
  }
  /// x := L^-T x
  void backward(double* x) const {
    x[2] /= l[5];
    x[1] = (x[1] - l[4] * x[2]) / l[2];
    x[0] = (x[0] - l[1] * x[1] - l[3] * x[2]) / l[0];
  }
};

}  // namespace collinea::bundle
