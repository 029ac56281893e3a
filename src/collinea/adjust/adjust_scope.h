// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <map>
#include <optional>
#include <set>

#include "collinea/adjust/calibration.h"
#include "collinea/base/id.h"
#include "collinea/block/instruments.h"
#include "collinea/camera/camera.h"

namespace collinea {

/// Where up is in the frame of a camera: by the attitude it wrote down, or by how images are held.
struct GivenVertical {
  Eigen::Vector3d up_in_cam;  ///< unit vector
  double sigma_rad = 0;
};

/// What takes part and what is fixed. As it stands: everything moves, everything known is used, and positions are those
/// of projection centres.
struct AdjustScope : Instruments {
  /// Nothing: every oriented image moves. Otherwise only these move; other images that see the same points take part,
  /// fixed where they are (local adjustment).
  std::optional<std::set<ImageId>> free_images;
  std::set<ImageId> fixed_images;    ///< fixed even if free otherwise
  std::set<CameraId> fixed_cameras;  ///< not calibrated
  std::set<PointId> fixed_points;    ///< tie points that stay where they are
  /// The cameras as they were before any adjustment: the values of the pseudo-observations below. A camera that is not
  /// named counts as it stands in the block.
  std::map<CameraId, Camera> first_cameras;
  std::map<CameraId, CameraSigmas> camera_sigmas;  ///< of cameras that are not calibrated as the options say
  /// Cameras of kBrownOfMeasured whose measurements are compared after correction, where their sigmas then hold, as
  /// PhotoModeler and DBAT do. Residuals are then those, too. Else they are compared where they were measured.
  std::set<CameraId> corrected_cameras;
  std::map<ImageId, GivenVertical> verticals;  ///< observations of the attitudes of images
  bool use_positions = true;                   ///< Image::position
  bool use_control = true;                     ///< ControlRole::kControl; when false they are treated as check points
  bool use_geodetic = true;                    ///< Block::geodetic; not in a local adjustment
  /// Image measurements of check points take part as those of tie points do, but without a loss; their coordinates are
  /// compared. Otherwise a check point is where the adjusted images see it.
  bool use_check_rays = false;
};

/// The scope with every camera in first_cameras, as it stands where it is not named: so the pseudo-observations stay
/// those of the beginning, however often the block is adjusted and takes the outcome.
[[nodiscard]] inline AdjustScope with_first_cameras(AdjustScope scope, const std::map<CameraId, Camera>& cameras) {
  scope.first_cameras.insert(cameras.begin(), cameras.end());
  return scope;
}

}  // namespace collinea
