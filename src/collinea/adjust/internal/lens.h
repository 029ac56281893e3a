// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <type_traits>
#include <variant>

#include "collinea/camera/camera.h"

namespace collinea::bundle {

/// What is compared with what. Models of camera/models.h that have a fast version here are named in fast_kind().
enum class LensKind : std::uint8_t {
  kBrown,     ///< the pixel where the point is seen, with the pixel that was measured
  kMeasured,  ///< the same for BrownOfMeasured
  /// The measured coordinates after correction, with X/Z and Y/Z, both times f [px]: AdjustScope::corrected_cameras.
  kCorrected,
  kGeneral  ///< as kBrown, for all other models and with additional parameters
};

/// A camera laid out for the inner loop of the adjustment. The mathematics is that of camera/camera.h (a test compares
/// the two; kGeneral calls it); here it is inline for the common model, and knows the edge of its field of view
/// beforehand.
struct Lens {
  double f = 0, fx = 0, b2 = 0, cx = 0, cy = 0;  // fx = f + b1
  double k1 = 0, k2 = 0, k3 = 0, p1 = 0, p2 = 0;
  double max_r2 = 0;   ///< of X/Z, Y/Z: where a point is no longer seen; infinite when nowhere; -1: not of kBrown
  double fold_r2 = 0;  ///< where the radial polynomial stops growing
  LensKind kind = LensKind::kBrown;
  // Members of kGeneral alone:
  CameraModel model;
  AdditionalSet additional = AdditionalSet::kNone;
  ImageExtent size;
  std::array<double, Camera::kAllParams> params{};
};

/// The version of a model without additional parameters: the general one, unless there is a fast one.
template <class Model>
[[nodiscard]] constexpr LensKind fast_kind() {
  if (std::is_same_v<Model, Brown>) return LensKind::kBrown;
  if (std::is_same_v<Model, BrownOfMeasured>) return LensKind::kMeasured;
  return LensKind::kGeneral;
}
[[nodiscard]] inline LensKind kind_of(const Camera& camera, bool compare_corrected) {
  if (camera.additional != AdditionalSet::kNone) return LensKind::kGeneral;
  const LensKind kind = std::visit([]<class Model>(const Model&) { return fast_kind<Model>(); }, camera.model);
  return kind == LensKind::kMeasured && compare_corrected ? LensKind::kCorrected : kind;
}
[[nodiscard]] Lens lens_of(const Camera& camera, bool compare_corrected);
/// The same lens with other Camera::params.
[[nodiscard]] Lens lens_with(const Lens& lens, const double* params);

/// A point of the camera frame on its way to the image.
struct Projected {
  double pixel[2];
  double x, y, r2;  // X/Z, Y/Z, x^2 + y^2; of kGeneral X, Y, Z
  double xd, yd;    // measured coordinates; of kCorrected those of the pixel that was measured; not of kGeneral
};

// Projection and derivatives of the other kinds.
bool project_other(const Lens& lens, const double* point_in_cam, const double* measured_pixel, Projected* out);
void derive_other_by_point(const Lens& lens, const Projected& at, double z, double* by_point);
void derive_other_by_params(const Lens& lens, const Projected& at, double* by_params);

/// Where the point is seen by a lens of kBrown; any other answers false.
inline bool project_brown(const Lens& lens, const double* point_in_cam, Projected* out) {
  if (!(point_in_cam[2] > 0)) return false;
  const double w = 1 / point_in_cam[2], x = point_in_cam[0] * w, y = point_in_cam[1] * w;
  const double r2 = x * x + y * y;
  if (!(r2 < lens.max_r2)) return false;
  const double radial = 1 + r2 * (lens.k1 + r2 * (lens.k2 + r2 * lens.k3));
  out->x = x;
  out->y = y;
  out->r2 = r2;
  out->xd = x * radial + lens.p1 * (r2 + 2 * x * x) + 2 * lens.p2 * x * y;
  out->yd = y * radial + lens.p2 * (r2 + 2 * y * y) + 2 * lens.p1 * x * y;
  out->pixel[0] = lens.cx + lens.fx * out->xd + lens.b2 * out->yd;
  out->pixel[1] = lens.cy + lens.f * out->yd;
  return true;
}

/// Where the point is seen, to be compared with the measured pixel (of kCorrected the measured one less the difference
/// after correction). False when the point is not seen: behind the camera or outside the field of view.
inline bool project(const Lens& lens, const double* point_in_cam, const double* measured_pixel, Projected* out) {
  if (project_brown(lens, point_in_cam, out)) return true;
  return lens.kind != LensKind::kBrown && project_other(lens, point_in_cam, measured_pixel, out);
}

/// d(pixel) / d(point in camera frame), 2 x 3 by rows, of a point that was projected by a lens of kBrown.
inline void derive_brown_by_point(const Lens& lens, const Projected& at, double z, double* by_point) {
  const double x = at.x, y = at.y, r2 = at.r2, w = 1 / z;
  const double radial = 1 + r2 * (lens.k1 + r2 * (lens.k2 + r2 * lens.k3));
  const double by_r2 = 2 * (lens.k1 + r2 * (2 * lens.k2 + r2 * 3 * lens.k3));
  const double dx_dx = radial + x * x * by_r2 + 6 * lens.p1 * x + 2 * lens.p2 * y;
  const double dx_dy = x * y * by_r2 + 2 * lens.p1 * y + 2 * lens.p2 * x;
  const double dy_dy = radial + y * y * by_r2 + 6 * lens.p2 * y + 2 * lens.p1 * x;
  const double col_dx = (lens.fx * dx_dx + lens.b2 * dx_dy) * w, col_dy = (lens.fx * dx_dy + lens.b2 * dy_dy) * w;
  const double row_dx = lens.f * dx_dy * w, row_dy = lens.f * dy_dy * w;
  by_point[0] = col_dx;
  by_point[1] = col_dy;
  by_point[2] = -(col_dx * x + col_dy * y);
  by_point[3] = row_dx;
  by_point[4] = row_dy;
  by_point[5] = -(row_dx * x + row_dy * y);
}

/// The same of any lens.
inline void derive_by_point(const Lens& lens, const Projected& at, double z, double* by_point) {
  if (lens.kind == LensKind::kBrown) return derive_brown_by_point(lens, at, z, by_point);
  derive_other_by_point(lens, at, z, by_point);
}

/// d(pixel) / d(Camera::params), 2 x Camera::kAllParams by rows, of a point that was projected: those that the model
/// has.
inline void derive_by_params(const Lens& lens, const Projected& at, double* by_params) {
  if (lens.kind != LensKind::kBrown) [[unlikely]]
    return derive_other_by_params(lens, at, by_params);
  const double x = at.x, y = at.y, r2 = at.r2, r4 = r2 * r2, r6 = r4 * r2;
  const double column = lens.fx * x + lens.b2 * y, row = lens.f * y;
  const double xp1 = r2 + 2 * x * x, xy2 = 2 * x * y, yp2 = r2 + 2 * y * y;
  double* c = by_params;
  c[Camera::kF] = at.xd, c[Camera::kCx] = 1, c[Camera::kCy] = 0;
  c[Camera::kK1] = column * r2, c[Camera::kK2] = column * r4, c[Camera::kK3] = column * r6;
  c[Camera::kP1] = lens.fx * xp1 + lens.b2 * xy2, c[Camera::kP2] = lens.fx * xy2 + lens.b2 * yp2;
  c[Camera::kB1] = at.xd, c[Camera::kB2] = at.yd;
  double* r = by_params + Camera::kAllParams;
  r[Camera::kF] = at.yd, r[Camera::kCx] = 0, r[Camera::kCy] = 1;
  r[Camera::kK1] = row * r2, r[Camera::kK2] = row * r4, r[Camera::kK3] = row * r6;
  r[Camera::kP1] = lens.f * xy2, r[Camera::kP2] = lens.f * yp2;
  r[Camera::kB1] = 0, r[Camera::kB2] = 0;
}

}  // namespace collinea::bundle
