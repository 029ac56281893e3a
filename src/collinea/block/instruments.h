// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <map>
#include <vector>

#include "collinea/base/id.h"

namespace collinea {

/// The whole attitude of an image, as an inertial system says.
struct GivenAttitude {
  Eigen::Quaterniond cam_from_world;
  Eigen::Vector3d sigma_rad;  ///< of turns about x, y, z of the world: two of level and one of heading
};

/// From the projection centre to the antenna whose position Image::position is.
struct LeverArm {
  Eigen::Vector3d antenna_in_cam_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d sigma_m = Eigen::Vector3d::Zero();  ///< 0: exact; infinite: not known
};

/// Images whose positions have a shift in common and a drift, which grows with time.
struct PositionTrack {
  std::map<ImageId, double> time;                           ///< in any unit, of no use without a drift; best about zero
  Eigen::Vector3d shift_sigma_m = Eigen::Vector3d::Zero();  ///< 0: there is none; infinite: not known
  Eigen::Vector3d drift_sigma_m = Eigen::Vector3d::Zero();  ///< the same, in a unit of time
};

/// What receivers and inertial systems measure beside Image::position, and what of their mounting is not known.
struct Instruments {
  std::map<ImageId, GivenAttitude> attitudes;
  /// Sigmas of the rotation from the camera that `attitudes` mean to the true one, about its axes: 0 there is none,
  /// infinite not known.
  std::map<CameraId, Eigen::Vector3d> boresight_sigma_rad;
  std::map<CameraId, LeverArm> lever_arms;
  std::vector<PositionTrack> position_tracks;  ///< an image is in one at most
  /// By how much later than the exposure the position was taken, of all images of a camera. 0: at once; infinite: not
  /// known. Images without a velocity know nothing of it.
  std::map<CameraId, double> time_offset_sigma_s;
  std::map<ImageId, Eigen::Vector3d> velocity_m_s;  ///< of the antenna through the world, while the image was taken
};

}  // namespace collinea
