// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <map>
#include <vector>

#include "collinea/adjust/solved.h"
#include "collinea/quality/internal/free_network.h"

namespace collinea {

/// How a parameter of a camera goes with one of the six of an image: with what differs least from it in its effect.
struct CameraPoseCorrelation {
  CameraId camera;
  int param = 0;  ///< Camera::Param
  /// 0 to 2: rotations about x, y and z of the world, in the sense of pose_covariances(): the world turned before the
  /// camera; 3 to 5: the projection centre along them; 6 to 8: omega, phi and kappa, to which the camera is turned (for
  /// a nadir image those of 0 to 2 with the opposite sign).
  int of_pose = 0;
  ImageId image;  ///< of the camera's images the one with the largest
  double correlation = 0;
};

/// Nine of each free parameter of each camera, by the selected inverse and the covariances of the poses
/// (pose_covariances). Of a free network they are in the datum of these, that of all tie points: a correlation with a
/// pose depends on what positions and attitudes refer to.
[[nodiscard]] std::vector<CameraPoseCorrelation> correlate_cameras_and_poses(
    const Solved& solved, const std::map<ImageId, Eigen::Matrix<double, 6, 6>>& pose_covariance,
    const bundle::FreeNetwork& free_network, bundle::TileCholesky& inverse);

}  // namespace collinea
