// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "collinea/geometry/rigid3.h"

namespace collinea {

/// The point seen at the undistorted image coordinates (X/Z, Y/Z) `normalized_xy[i]` by the camera `cam_from_world[i]`:
/// meeting of the rays by linear least squares, then Gauss-Newton on the image coordinates, all rays of equal weight.
/// Nothing with fewer than two rays, when no two rays meet at min_angle_rad or more, or when the point is not in front
/// of every camera.
[[nodiscard]] std::optional<Eigen::Vector3d> intersect_rays(std::span<const Rigid3> cam_from_world,
                                                         std::span<const Eigen::Vector2d> normalized_xy,
                                                         double min_angle_rad = 1e-3);

/// Two rays only, without iteration: the middle of their shortest connection. A few ten nanoseconds; not the
/// least-squares answer when the rays miss each other. Nothing as above.
[[nodiscard]] std::optional<Eigen::Vector3d> intersect_midpoint(const Rigid3& first_from_world,
                                                                  const Rigid3& second_from_world,
                                                                  const Eigen::Vector2d& first_xy,
                                                                  const Eigen::Vector2d& second_xy,
                                                                  double min_angle_rad = 1e-3);

/// The largest angle [rad] under which two of the projection centres are seen from the point; 0 for fewer than two.
[[nodiscard]] double max_ray_angle_rad(std::span<const Rigid3> cam_from_world, const Eigen::Vector3d& point_in_world);

/// The distance [px] between an image point and the projection of `point_in_world`; infinite behind the camera.
[[nodiscard]] double reprojection_error_px(const Rigid3& cam_from_world, const Eigen::Vector2d& normalized_xy,
                                           double focal_px, const Eigen::Vector3d& point_in_world);

/// A point with the rays that agree on it.
struct RobustPoint {
  Eigen::Vector3d point_in_world;
  std::vector<std::uint8_t> inlier;  ///< per ray: 1 when it passes within max_error_px
  int inliers = 0;
  double max_angle_rad = 0;  ///< between two inlier rays
  double rms_px = 0;         ///< of the inliers, per ray
};

/// Triangulation of a track that may hold wrong measurements: every pair of rays (an even selection of pairs when there
/// are more than 100) proposes a point, the proposal with the least truncated error is refined over the rays that pass
/// within max_error_px of it, until these no longer change. focal_px[i] turns ray i's distances into pixels. Nothing
/// when fewer than min_inliers rays agree, or they are parallel within min_angle_rad.
[[nodiscard]] std::optional<RobustPoint> robust_intersect(std::span<const Rigid3> cam_from_world,
                                                            std::span<const Eigen::Vector2d> normalized_xy,
                                                            std::span<const double> focal_px, double max_error_px,
                                                            double min_angle_rad = 1e-3, int min_inliers = 2);

}  // namespace collinea
