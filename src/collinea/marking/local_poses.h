// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "collinea/block/block.h"

namespace collinea {

using PoseCovariances = std::map<ImageId, Eigen::Matrix<double, 6, 6>>;

/// Some images of an oriented block with the covariance of all their poses together. Of each image [rotation (rad, in
/// world), centre]: true rotation = rotation * rotation_by(e).
struct LocalPoses {
  std::vector<ImageId> images;
  std::vector<Rigid3> cam_from_world;  ///< parallel to images
  Eigen::MatrixXd information;         ///< 6 n x 6 n, the inverse of ...
  Eigen::MatrixXd covariance;          ///< ... the covariance
};

/// The joint covariance of the poses of images near each other. What they know of each other comes from the tie points
/// that two and more of them see, points eliminated (Schur complement); where they lie as a whole, from the covariances
/// that the adjustment of the whole block gave each of them:
///
///     C = (S / sigma0^2 + 1/n sum C_ii^-1)^-1,     S: reduced normals of the tie points
///
/// A shift of all images together has then the mean information of one image, as it must; what other images add to how
/// these lie to each other is left out. Cameras are taken as exact. Of many tie points an even selection stands for
/// all.
///
/// `observations`: of each image, indices in Block::observations. `poses`: by the given sigmas; empty: the block's
/// location is not known beyond a tenth of the distances (and kLooseRotation_rad). Nothing with no image, or an image
/// that is not oriented. Cost: n^2 for each tie point and n^3; some 50 ms for forty images.
[[nodiscard]] std::optional<LocalPoses> local_poses(const Block& block,
                                                    const std::map<ImageId, std::vector<std::size_t>>& observations,
                                                    std::span<const ImageId> images, const PoseCovariances& poses,
                                                    double sigma0);
inline constexpr double kLooseRotation_rad = 0.1;

/// Where a pose shows a point, and how that depends on both.
struct LinearPixel {
  Eigen::Vector2d pixel;
  Eigen::Matrix<double, 2, 3> by_point;
  Eigen::Matrix<double, 2, 6> by_pose;
};
/// Nothing when the point lies behind the camera. `by_camera` (may be null) receives the derivatives by Camera::params.
[[nodiscard]] std::optional<LinearPixel> linear_pixel(const Camera& camera, const Rigid3& cam_from_world,
                                                      const Eigen::Vector3d& point_in_world,
                                                      Matrix2P* by_camera = nullptr);

}  // namespace collinea
