// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "collinea/camera/additional.h"
#include "collinea/camera/internal/models.h"
#include "collinea/camera/internal/parameters.h"
#include "collinea/camera/internal/prior.h"

namespace collinea {

/// The interior orientation of a camera with one lens and one focus setting: a projection with the distortion of
/// Brown (1971) and the affinity and shear of the sensor. The polynomial D of the distortion is, with
/// r2 = x^2 + y^2,
///     radial = k1 r2 + k2 r2^2 + k3 r2^3 + k4 r2^4
///     D(x, y) = (x + x radial + p1 (r2 + 2 x^2) + 2 p2 x y,
///                y + y radial + p2 (r2 + 2 y^2) + 2 p1 x y)
/// The measured coordinates (xd, yd) of a point X, Y, Z of the camera frame follow from
///     Brown:            (xd, yd) = D(X/Z, Y/Z)
///     BrownOfMeasured:  D(xd, yd) = (X/Z, Y/Z)
///     fisheyes:         (xd, yd) = D(g X/R, g Y/R), R = hypot(X, Y), t = atan2(R, Z), g(t) the law of the model
/// where parameters that a model does not have are zero. The pixel:
///     column = cx + f xd + b1 xd + b2 yd,   row = cy + f yd
/// and on top of it the shift of the additional parameters at that pixel (camera/additional.h).
/// Pixel convention: the centre of the upper-left pixel is (0.5, 0.5). Camera frame: x right, y down, z forward.
struct Camera : CameraParameters {
  std::array<double, kAllParams> params{};  ///< of the model, then of the additional set [px]; the others are zero
  CameraModel model;                        ///< Brown, unless another is stated
  AdditionalSet additional = AdditionalSet::kNone;
  int width_px = 0;
  int height_px = 0;
  std::string name;  ///< maker, model, serial: for people
  CameraPrior prior;

  [[nodiscard]] double focal_px() const { return params[kF]; }
};

/// Whether it is that of a scan of film whose local deformation takes part.
[[nodiscard]] inline bool is_deformed_film(const Camera& camera) {
  return camera.additional == AdditionalSet::kFilm && camera.prior.film;
}

/// A camera without distortion whose principal point is the middle of the image.
[[nodiscard]] Camera ideal_camera(double focal_px, int width_px, int height_px);

/// Those of Camera::params that the camera's model and additional set have, ascending.
[[nodiscard]] std::vector<int> params_of(const Camera& camera);
/// "k1"; of the additional ones "a1" and so on.
[[nodiscard]] std::string param_name(int param);
[[nodiscard]] std::string_view param_unit(int param);
/// The parameter of that name, if the camera has it.
[[nodiscard]] std::optional<int> param_named(const Camera& camera, std::string_view name);

/// The camera of images resampled to `times` their size.
void scale_params(Camera& camera, double times);

/// Where a point of the camera frame is seen [px]; nothing when it lies behind the camera (of a fisheye: on its axis
/// behind it) or so far outside the field of view that the distortion polynomial folds back (its radial derivative is
/// no longer positive). Where the polynomial is one of measured coordinates it is inverted by Newton iteration, to
/// rounding.
[[nodiscard]] std::optional<Eigen::Vector2d> project(const Camera& camera, const Eigen::Vector3d& point_in_cam);

/// The same, with the derivatives of the pixel by the point and by the camera's parameters.
[[nodiscard]] std::optional<Eigen::Vector2d> project(const Camera& camera, const Eigen::Vector3d& point_in_cam,
                                                     Matrix23* by_point, Matrix2P* by_params);

/// What the mathematics needs of a camera, without its words: others may keep the numbers.
struct CameraCore {
  const double* params;  ///< Camera::params
  CameraModel model;
  AdditionalSet additional;
  ImageExtent size;
};

/// project() of the camera with that core.
[[nodiscard]] std::optional<Eigen::Vector2d> project(const CameraCore& camera, const Eigen::Vector3d& point_in_cam,
                                                     Matrix23* by_point, Matrix2P* by_params);

/// The undistorted image coordinates (X/Z, Y/Z) of a pixel: the inverse of project. As exact as its model says.
/// Rays of a fisheye beyond kWidestPlane_rad have no such coordinates that are of use: they get those of that
/// angle, in their direction; see in_plane().
[[nodiscard]] Eigen::Vector2d normalized(const Camera& camera, const Eigen::Vector2d& pixel);

/// The pixel freed from the shift of the additional parameters.
[[nodiscard]] Eigen::Vector2d without_additional(const Camera& camera, const Eigen::Vector2d& pixel);

/// Whether normalized() is that of the pixel's ray.
[[nodiscard]] bool in_plane(const Camera& camera, const Eigen::Vector2d& pixel);

/// How many pixels a unit of X/Z, Y/Z is in the image at a position: the focal length of a central projection, less and
/// less towards the rim of a fisheye (the mean of along and across the radius).
[[nodiscard]] double pixels_per_unit(const Camera& camera, const Eigen::Vector2d& normalized_xy);

/// The unit direction of a pixel in the camera frame.
[[nodiscard]] Eigen::Vector3d ray_in_cam(const Camera& camera, const Eigen::Vector2d& pixel);

/// True when the pixel lies on the image: [0, width] x [0, height].
[[nodiscard]] inline bool inside(const Camera& camera, const Eigen::Vector2d& pixel) {
  return pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() <= camera.width_px && pixel.y() <= camera.height_px;
}

}  // namespace collinea
