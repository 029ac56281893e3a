// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include "collinea/adjust/internal/problem.h"
#include "collinea/adjust/observation_group.h"

namespace collinea::bundle {

struct DatumPart;

// A measured image point: the pixel at which the lens of its image sees the point X,
//
//     x = lens(R (X - c)),
//
// with the rotation R (cam_from_world) and the projection centre c. Two coordinates with one loss, and mostly one
// sigma; where their covariance is another, Whitening makes two independent ones of them. What the inner loops of the
// adjustment need is inline.

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
  Whitening whitening;
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
  double residual[2] = {(ray.pixel[0] - at.pixel[0]) * ray.inverse_sigma,
                        (ray.pixel[1] - at.pixel[1]) * ray.inverse_sigma};
  if (!ray.whitening.is_plain()) [[unlikely]]
    ray.whitening.apply(residual, 1);
  return residual[0] * residual[0] + residual[1] * residual[1];
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
  double residual[2] = {(ray.pixel[0] - out->at.pixel[0]) * ray.inverse_sigma,
                        (ray.pixel[1] - out->at.pixel[1]) * ray.inverse_sigma};
  out->whitening = ray.whitening;
  const bool is_plain = ray.whitening.is_plain();
  if (!is_plain) [[unlikely]]
    ray.whitening.apply(residual, 1);
  const double u = residual[0], v = residual[1], s = u * u + v * v;
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
  if (!is_plain) [[unlikely]]
    ray.whitening.apply(d, 3);
  out->shrink = 0;
  if (loss.kind != Loss::kNone) bend(loss, s, d, out);
  for (int row = 0; row < 2; ++row) {
    const double* a = d + 3 * row;
    double* rotation = out->by_rotation + 3 * row;  // -d [p]x
    rotation[0] = a[2] * p[1] - a[1] * p[2];
    rotation[1] = a[0] * p[2] - a[2] * p[0];
    rotation[2] = a[1] * p[0] - a[0] * p[1];
    double* move = out->by_point + 3 * row;
    for (int c = 0; c < 3; ++c) move[c] = a[0] * frame[c] + a[1] * frame[3 + c] + a[2] * frame[6 + c];
  }
  return s;
}

/// linearise() of any other lens.
double linearise_other(const Ray& ray, const Frame& frame, const Lens& lens, const double* point, const Loss& loss,
                       LinearRay* out);

/// square_of() with derivatives. An observation that is not seen has a square but all zero derivatives and residual.
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
  if (!ray.whitening.is_plain()) [[unlikely]]
    ray.whitening.apply(by_camera, static_cast<int>(count));
  if (ray.shrink > 0) shrink_along(ray, by_camera, static_cast<int>(count));
}

/// linearise() of a ray of the problem whose point is at `position`.
[[gnu::always_inline]] inline double linearise(const Problem& problem, const State& state, const Ray& ray,
                                               const double* position, const Loss& loss, LinearRay* out) {
  return linearise(ray, state.frames[ray.image], state.lenses[problem.images[ray.image].camera], position, loss, out);
}

/// The kind of observation of image points, of tie points and of control. Its loops are those of points, which are
/// eliminated with it: normal equations and steps take linearise() and square_of() from above; what is asked once
/// after an adjustment is asked here.
struct ImagePoint {
  /// A ray and its point.
  struct Item {
    std::size_t point;  ///< index in Problem::points
    std::uint32_t ray;  ///< index in Problem::rays
  };
  static constexpr int kSize = 2;
  static constexpr bool kIsTested = true;
  static constexpr bool kIsOfPoint = true;
  static constexpr bool kIsOfPosition = false;  ///< a motion of the whole block leaves it as it is

  template <class Visit>
  static void for_each(const Problem& problem, Visit&& visit) {
    for (std::size_t p = 0; p < problem.point_count(); ++p) for_each_of(problem, p, visit);
  }
  /// Those of one point.
  template <class Visit>
  static void for_each_of(const Problem& problem, std::size_t point, Visit&& visit) {
    for (std::uint32_t r = problem.point(point).first_ray; r < problem.end_ray(point); ++r) visit(Item{point, r});
  }
  static long count(const Problem&, const Item&) { return kSize; }
  /// Robust for tie points, never for control.
  static Loss loss(const Problem& problem, const Item& item) { return problem.loss_of(problem.point(item.point)); }

  /// Observed minus computed [px]; nothing when its image does not see the point.
  static std::optional<Eigen::Vector2d> residual(const Problem& problem, const State& state, const Item& item) {
    const Ray& ray = problem.rays[item.ray];
    double in_cam[3];
    Projected at{};
    to_camera(state.frames[ray.image], &state.points[3 * item.point], in_cam);
    if (!project(state.lenses[problem.images[ray.image].camera], in_cam, ray.pixel, &at)) return std::nullopt;
    return Eigen::Vector2d(ray.pixel[0] - at.pixel[0], ray.pixel[1] - at.pixel[1]);
  }
  /// The square of a residual in units of its sigma.
  static double squared(const Problem& problem, const Item& item, const Eigen::Vector2d& residual_px) {
    const Ray& ray = problem.rays[item.ray];
    if (!ray.whitening.is_plain()) return whitened(ray, residual_px).squaredNorm();
    return residual_px.squaredNorm() * ray.inverse_sigma * ray.inverse_sigma;
  }
  /// A residual in units of its sigma times sigma0, as two independent ones.
  static Eigen::Vector2d whitened(const Ray& ray, const Eigen::Vector2d& residual_px, double sigma0 = 1) {
    Eigen::Vector2d residual = residual_px * (ray.inverse_sigma / sigma0);
    if (!ray.whitening.is_plain()) ray.whitening.apply(residual.data(), 1);
    return residual;
  }

  /// Each free image of a point with the first of them, also with itself; points that are fixed tie nothing.
  template <class Visit>
  static void for_each_tied_images(const Problem& problem, Visit&& visit) {
    for (std::size_t p = 0; p < problem.point_count(); ++p) {
      if (problem.point(p).is_fixed) continue;
      const std::uint32_t first = problem.point(p).first_free;
      for (std::uint32_t r = first; r < problem.end_ray(p); ++r)
        visit(problem.rays[first].image, problem.rays[r].image);
    }
  }
  /// Of point p, which a free image shows: images see where a fixed point is, and the rays of fixed images fix the
  /// direction of others.
  static void observe_motions(const Problem& problem, const State& state, std::size_t p, std::vector<DatumPart>& parts);

  static bool positions_block(const Problem&) { return false; }
  static bool is_gauge_complete(const Problem&) { return true; }
  static bool needs_rows_for_datum(const Problem&) { return false; }

  static bool is_tie(const Problem& problem, const Item& item) { return problem.point(item.point).control < 0; }
  static ObservationGroup group(const Problem& problem, const Item& item) {
    return is_tie(problem, item) ? ObservationGroup::kTieImages : ObservationGroup::kControlImages;
  }
  /// Index in Block::observations or, of control, Block::control_observations.
  static std::uint32_t source(const Problem& problem, const Item& item) { return problem.rays[item.ray].source; }
};

}  // namespace collinea::bundle
