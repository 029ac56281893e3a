// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>

#include "collinea/block/block.h"

namespace collinea {

/// Cameras and poses that come from another program.
struct GivenOrientation {
  std::map<ImageId, Rigid3> cam_from_world;
  std::map<CameraId, Camera> cameras;  ///< none: the source knows no cameras; they are calibrated on its poses
  bool in_world = false;               ///< the poses are in the block's world frame, and that is a location on Earth
  std::string source;                  ///< file or folder, for people
};

/// Whether poses agree with three and more control points, or else with the positions of their images, as they lie:
/// the median difference is below five standard deviations.
[[nodiscard]] bool lies_in_world(const Block& block);

}  // namespace collinea
