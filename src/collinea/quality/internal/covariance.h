// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <map>
#include <utility>
#include <vector>

#include "collinea/adjust/solved.h"
#include "collinea/base/run.h"
#include "collinea/quality/internal/free_network.h"

namespace collinea {

// Covariances of an adjustment's estimate, by the given sigmas: where these are only known up to scale, multiply by
// sigma0^2 (sigma_scale()).
//
// Model. The estimate x follows the observations l with the covariance P^-1 by (A'PA) x = A'P l, so that its covariance
// is C = (A'PA)^-1; robust losses take part by their weights, so that C is that of the robust estimate. Of images and
// cameras C is the inverse of the reduced normal matrix, of which only the elements are computed where that matrix has
// tiles (selected inverse, Takahashi 1973): those of each image and camera, and of images that share a point. A point
// adds the errors of its own rays: L^-T (I + Z' Q Z) L^-1, see PointSystem.
//
// Rank and datum. Where nothing fixes the block, covariances of poses and points refer to the datum of all tie points
// (FreeNetwork: the least trace there is), those of cameras do not depend on it. Where something is undetermined beyond
// the datum there is no factor and so none of this (Solved::factor()).
//
// Example, in a block of one camera:
//
//     auto [factor, failed_row] = solved.factor(run);
//     const bundle::FreeNetwork free_network(solved, *factor);
//     factor->invert(run);
//     const std::map<ImageId, Matrix6d> poses = pose_covariances(solved, free_network, *factor);
//     const double sigma_east_m = sigma_scale(solved.estimate()) * std::sqrt(poses.at(image)(3, 3));
//
// examine() does all of it. `inverse` is the factor after invert().

using MatrixPd = Eigen::MatrixXd;  ///< of as many of Camera::params as the camera's last one needs

/// Covariances of [rotation (rad, in world), centre (m, in world)] of each image: true rotation = rotation *
/// rotation_by(e).
///
/// Sense. Rotations are cam_from_world, so that e turns the axes of the world before a camera that stays; the camera
/// itself is turned by -e, and so are omega, phi and kappa. Sigmas do not tell the one from the other, correlations of
/// a rotation with a centre or with a parameter of the camera do: they have the opposite sign (see
/// covariance_of_angles).
[[nodiscard]] std::map<ImageId, Matrix6d> pose_covariances(const Solved& solved,
                                                           const bundle::FreeNetwork& free_network,
                                                           bundle::TileCholesky& inverse);

/// How small errors of [rotation, centre], in the sense above, become those of [omega, phi, kappa (rad), centre (m)],
/// in the world: the angles of omega_phi_kappa(cam_from_world).
[[nodiscard]] Matrix6d angles_by_rotation(const Eigen::Quaterniond& cam_from_world);
/// A covariance of the above as that of [omega, phi, kappa (rad), centre (m)].
[[nodiscard]] inline Matrix6d covariance_of_angles(const Matrix6d& covariance,
                                                   const Eigen::Quaterniond& cam_from_world) {
  const Matrix6d by_rotation = angles_by_rotation(cam_from_world);
  return by_rotation * covariance * by_rotation.transpose();
}

/// Covariances of Camera::params of each calibrated camera, zero for those fixed.
[[nodiscard]] std::map<CameraId, MatrixPd> camera_covariances(const Solved& solved, bundle::TileCholesky& inverse);

/// Covariances of the tie points [m^2], in the order of `points`, which are Adjusted::points.
[[nodiscard]] std::vector<Eigen::Matrix3d> point_covariances(
    const Solved& solved, const std::vector<std::pair<PointId, Eigen::Vector3d>>& points,
    const bundle::FreeNetwork& free_network, bundle::TileCholesky& inverse, const Run& run);

/// Fills the standard deviations of unknowns beside images, cameras and points, and of what was measured on the ground.
void predict_others(const Solved& solved, const bundle::FreeNetwork& free_network, bundle::TileCholesky& inverse,
                    Adjusted& adjusted);

namespace bundle {

/// Some rows and columns of the selected inverse.
[[nodiscard]] Eigen::MatrixXd block_of(TileCholesky& inverse, int row, int rows, int column, int columns);

/// The cofactor a Q a' of an observation by one pose and unknowns of the global parameters, `row` being a.
[[nodiscard]] double variance_of(const Row& row, TileCholesky& inverse);

}  // namespace bundle
}  // namespace collinea
