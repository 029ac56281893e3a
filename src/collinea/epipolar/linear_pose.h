// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "collinea/epipolar/projection_matrix.h"
#include "collinea/geometry/rigid3.h"

namespace collinea {

/// A pose by linear equations, and what the errors of the image coordinates make of it, to first order.
struct LinearPose {
  Rigid3 cam_from_world;
  bool is_plane = false;  ///< the points lie on a plane: one equation more for each
  /// Of [rotation about the axes of the world (rad), centre], by the stated sigmas.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  int redundancy = 0;
  double sigma0 = 1;                     ///< of the measurements: what least squares still take up is not in it
  std::vector<Eigen::Vector2d> misfits;  ///< measured minus computed
  std::vector<Eigen::Vector2d> redundancies, w;
};

/// The pose of a camera with known interior orientation from points in space or on a plane, without start or iteration
/// (Fiore, Efficient linear solution of exterior orientation, PAMI 23, 2001), all points of equal weight:
///
///     l_i r_i = s (R X_i + t)      r_i = (x, y, 1), l_i its unknown depth
///     sum_j l_j r_j P_ji = 0       P = I - V V', V an orthonormal base of the columns of [X, 1]: nothing but depths
///     min l' G l, |l| = 1          G_ij = P_ij r_i . r_j, rays brought to mean 0 and unit size (Hartley)
///
/// then s, R, t by align() from X to l r. `in_image` of the points are x/z, y/z of the camera (z forward), sigmas in
/// that unit. The estimate is not least squares in the image: its covariance is that of its own derivatives,
/// dl = -G^+ dG l, and larger. Six points in space, four on a plane; points within 1e-5 of their extent of a plane
/// count as on it. Cost grows with the cube of the points.
///
/// Nothing with fewer points, on a line, when the depths are left open, when one of them is not positive, or when
/// points in space are seen mirrored (points whose thickness is lost in the errors can look so).
[[nodiscard]] std::optional<LinearPose> linear_pose(std::span<const ProjectedPoint> points);

}  // namespace collinea
