// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <map>
#include <vector>

#include "collinea/adjust/solved.h"

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

/// Nine of each free parameter of each camera, where the datum is complete: where it is chosen, so are correlations. By
/// the selected inverse and the covariances of the poses (pose_covariances).
[[nodiscard]] std::vector<CameraPoseCorrelation> correlate_cameras_and_poses(
    const Solved& solved, const std::map<ImageId, Eigen::Matrix<double, 6, 6>>& pose_covariance,
    bundle::TileCholesky& inverse);

}  // namespace collinea
