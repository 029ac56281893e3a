// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "collinea/geometry/rigid3.h"

namespace collinea {

/// A straight line of an image, in coordinates X/Z, Y/Z without distortion: x cos(theta) + y sin(theta) = r. With the
/// projection centre it spans a plane of rays, on which the line of the object lies.
struct ImageLine {
  Rigid3 cam_from_world;
  double theta_rad = 0, r = 0;
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Identity();  ///< of theta [rad], r
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();          ///< of the piece that was measured
  /// Of [rotation about the axes of the world (rad), centre (m)]; zero: exact.
  Eigen::Matrix<double, 6, 6> pose_covariance = Eigen::Matrix<double, 6, 6>::Zero();
};
/// The same line measured in pixels of a camera without distortion.
struct PixelLine {
  double theta_rad = 0, r_px = 0;
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Identity();  ///< of theta [rad], r [px]
  Eigen::Vector2d middle_px = Eigen::Vector2d::Zero();
};
[[nodiscard]] ImageLine image_line(const Rigid3& cam_from_world, double focal_px,
                                   const Eigen::Vector2d& principal_point_px, const PixelLine& line);

/// A straight line in space. Four parameters are free: shift and tilt across it.
struct SpaceLine {
  Eigen::Vector3d point, direction;    ///< direction of unit length
  Eigen::Matrix<double, 3, 2> across;  ///< two unit vectors across the direction, and across each other
  Eigen::Matrix4d covariance;          ///< of [shift of the point along `across` (m), tilt of the direction (rad)]
  int redundancy = 0;                  ///< 2 N - 4
  double squares = 0;                  ///< v' P v of the image lines
  double sigma0 = 1;                   ///< of unit weight; 1 of two images: they fit any line
  double angle_rad = 0, angle_sigma_rad = 0;  ///< the largest between two planes of rays

  [[nodiscard]] Eigen::Vector3d at(double along_m) const { return point + along_m * direction; }
  /// Of the position across the line, `along_m` from the point: rows and columns are `across`.
  [[nodiscard]] Eigen::Matrix2d covariance_at(double along_m) const;
  /// How far along the line, from its point, it comes nearest to the ray of an image point.
  [[nodiscard]] double nearest_to(const Rigid3& cam_from_world, const Eigen::Vector2d& xy) const;
};

/// The line where the planes of rays of two images and more meet, by least squares of theta and r with the covariances
/// given (orientations count as what they are in the image; those of different images are taken as independent):
///     N = (P - C) x d,   (a, b, c) = R N,   theta = atan2(b, a),   r = -c / hypot(a, b)
/// Two images leave no redundancy: any two planes meet (in general). Each image more adds two.
/// Nothing: fewer than two images; planes that meet under less than `least_angle_rad` or five times the standard
/// deviation of that angle (of two images: the line lies in an epipolar plane); a line behind a camera; no convergence.
/// `point` is the foot, on the line, of the ray through the middle of the first image's piece.
[[nodiscard]] std::optional<SpaceLine> intersect_lines(std::span<const ImageLine> lines, double least_angle_rad = 1e-3);

}  // namespace collinea
