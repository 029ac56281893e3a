// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <span>

#include "collinea/epipolar/internal/point_pairs.h"
#include "collinea/geometry/rigid3.h"
#include "collinea/math/few.h"

namespace collinea {

/// The homography with (x2, y2, 1) ~ H (x1, y1, 1) for four pairs, of Frobenius norm 1, by way of the projective bases
/// of both quadruples. Nothing when three of the points lie on a line in either image, or when the pairs cannot be
/// the two views of a plane in front of both cameras (the points swap sides).
[[nodiscard]] std::optional<Eigen::Matrix3d> four_point(const std::array<Eigen::Vector2d, 4>& first,
                                                        const std::array<Eigen::Vector2d, 4>& second);

/// Squared distance [px^2] of pair i from the nearest pair that obeys H, to first order (Sampson), both images
/// measured equally well: chi-squared with two degrees of freedom for unit noise. `out` has end - begin values.
void squared_errors(const Eigen::Matrix3d& homography, const PointPairs& pairs, int begin, int end, double* out);

/// The homography that minimises the squared errors of the pairs `support`, each capped smoothly at loss_px
/// (Geman-McClure), by Gauss-Newton from `start`. Nothing with fewer than four pairs or when they do not determine it.
[[nodiscard]] std::optional<Eigen::Matrix3d> refine_homography(const Eigen::Matrix3d& start, const PointPairs& pairs,
                                                               std::span<const int> support, double loss_px);

/// A motion (translation of unit length) and a plane normal that make a homography of undistorted image coordinates,
/// H ~ R + t n' / d with the plane n' X = d, d > 0, in the first camera frame.
struct PlanarMotion {
  Rigid3 second_from_first;
  Eigen::Vector3d normal_in_first;
  double base_over_distance;  ///< |t| / d: 0 for a pure rotation
};

/// The two motions with the points `support` in front of both cameras (Ma, Soatto, Kosecka, Sastry 2004, 5.3). None for
/// a pure rotation (base_over_distance < 1e-9).
[[nodiscard]] Few<PlanarMotion, 2> planar_motions(const Eigen::Matrix3d& homography, const PointPairs& pairs,
                                                  std::span<const int> support);

/// The rotation nearest to a homography between views from one centre (H ~ R).
[[nodiscard]] Eigen::Quaterniond nearest_rotation(const Eigen::Matrix3d& homography);

/// The rotation that minimises the squared errors of H = R for the pairs `support`, capped as in refine_homography.
/// Nothing with fewer than two pairs.
[[nodiscard]] std::optional<Eigen::Quaterniond> refine_rotation(const Eigen::Quaterniond& start,
                                                                const PointPairs& pairs, std::span<const int> support,
                                                                double loss_px);

}  // namespace collinea
