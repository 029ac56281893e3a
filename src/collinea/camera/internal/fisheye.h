// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "collinea/camera/internal/parameters.h"

namespace collinea {

/// 80 degrees from the axis: X/Z is 5.7 there and grows 33 times as fast as the angle.
inline constexpr double kWidestPlane_rad = 1.3962634015954636;

/// How far from the principal point a fisheye without distortion shows a direction, in focal lengths, and the
/// derivative of that by the angle from the axis.
struct FisheyeRadius {
  double g, by_angle;
};

/// What fisheyes have in common. A model of them is its law alone,
///     static FisheyeRadius radius(double angle_rad);   // g(t)
///     static double angle_rad(double g);               // its inverse; beyond the law's end the widest angle
/// and the measured coordinates of a point X, Y, Z of the camera frame are
///     (xd, yd) = D(g X/R, g Y/R),   R = hypot(X, Y), t = atan2(R, Z),   D the polynomial of camera/camera.h
/// The functions are those of camera.h of that name, of measured coordinates; they are defined in
/// camera/internal/fisheye_projection.h.
template <class Law>
struct Fisheye {
  static constexpr bool kIsFisheye = true;

  static std::optional<Eigen::Vector2d> project(const double* params, const Eigen::Vector3d& point_in_cam,
                                                Matrix23* by_point, Matrix2P* by_params);
  static Eigen::Vector2d normalized(const double* params, const Eigen::Vector2d& measured);
  static Eigen::Vector3d ray(const double* params, const Eigen::Vector2d& measured);
  static bool in_plane(const double* params, const Eigen::Vector2d& measured);
  static double pixels_per_unit(double focal_px, const Eigen::Vector2d& normalized_xy);
};

}  // namespace collinea
