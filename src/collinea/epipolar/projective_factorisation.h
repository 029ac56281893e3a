// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "collinea/base/result.h"

namespace collinea {

using ProjectionMatrix = Eigen::Matrix<double, 3, 4>;

/// The same points measured in several images: a matrix for each image, a column for each point.
struct ImageCoordinates {
  std::vector<Eigen::Matrix2Xd> xy;       ///< x right, y down
  std::vector<Eigen::RowVectorXd> sigma;  ///< of one coordinate, in its unit

  [[nodiscard]] std::size_t images() const { return xy.size(); }
  [[nodiscard]] Eigen::Index points() const { return xy.empty() ? 0 : xy[0].cols(); }
};

/// Cameras and points up to a collineation of space: image ~ M point.
struct ProjectiveModel {
  std::vector<ProjectionMatrix> matrices;  ///< unit norm
  Eigen::Matrix4Xd points;                 ///< homogeneous, unit norm
  std::vector<Eigen::Matrix2Xd> misfits;   ///< measured minus computed
  double sigma0 = 1;                       ///< of the stated sigmas; 1 without redundancy
  int redundancy = 0;                      ///< 2 m n - 11 m - 3 n + 15
  int alternations = 0;                    ///< of projective depths and factors
  int iterations = 0;                      ///< of the least squares in the images
  /// Fourth and fifth singular value over the first of the measurement matrix with the depths as found: a matrix of
  /// rank 4 has no fifth one, points of a plane or one projection centre leave no fourth one.
  double fourth = 0, fifth = 0;
};

/// Projective factorisation (Sturm and Triggs, ECCV 1996; Bolognesi 5.34-5.39 with the shapes of W and V corrected):
///     W = (lambda_ip (u_ip, 1)) = M P,   3m x n of rank 4, by singular value decomposition.
/// Coordinates are normalised image by image (Hartley 1997); the depths lambda begin with those of the fundamental
/// matrices of the first image with each other one and alternate with the factors, rows and columns scaled to one
/// length. That minimises an algebraic error (Bolognesi 5.39), so that least squares in the images follow: Gauss-Newton
/// over M and P, damped, the points eliminated. Its 15 + m free parameters (collineation, scales) are of no effect on
/// residuals.
///
/// Errors (ill-posed): fewer than two images or eight points; points on a plane or images from one centre (a pair
/// without fundamental matrix, a fourth singular value below 1e-4 of the first, or collineations of the first image
/// with all others that leave residuals below three sigmas, or twice those of the model); not converged.
/// 50 points in 5 images: some milliseconds.
[[nodiscard]] Result<ProjectiveModel> factorised(const ImageCoordinates& measured);

/// The fundamental matrix of two cameras, F = [e']x Q' Q^-1 with e' = q' - Q' Q^-1 q (Bolognesi 5.26), of unit norm,
/// written with 4 x 4 minors, which hold for a centre at infinity, too.
[[nodiscard]] Eigen::Matrix3d fundamental_of(const ProjectionMatrix& first, const ProjectionMatrix& second);

}  // namespace collinea
