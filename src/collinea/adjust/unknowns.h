// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <limits>

#include "collinea/base/finding.h"
#include "collinea/block/block.h"

namespace collinea {

/// Unknowns beside those of images, cameras and points.
enum class UnknownKind : std::uint8_t {
  kOrientation,  ///< azimuth of zero of a horizontal circle [rad]
  kLeverArm,     ///< of a camera, along its axes [m]
  kShift,        ///< of the positions of a track [m]
  kDrift,        ///< the same in a unit of its time [m]
  kBoresight,    ///< of a camera, a rotation vector about its axes: cam_from_world = turn * given [rad]
  kTimeOffset,   ///< of the positions of a camera after the exposures [s]
  kHeight,       ///< that points have in common: theirs above the world's origin [m]
  kPlane,        ///< against where it began: along its normal [m], two tilts [1]
  kLine,         ///< against where it began: sideways [m], [1] along it, upwards [m], [1]
};

/// Those of a shape that points are known to lie on.
[[nodiscard]] constexpr bool is_of_shape(UnknownKind kind) { return kind >= UnknownKind::kHeight; }

/// One of them, as estimated.
struct EstimatedUnknown {
  UnknownKind kind{};
  std::uint32_t owner = 0;  ///< number of the set-up, the shape or the track, or of a CameraId
  int axis = 0;
  double value = 0;
  double sigma = std::numeric_limits<double>::quiet_NaN();  ///< by the given sigmas; with covariances
};

/// What that unknown is of; `report` names it: "the orientation of set-up 3".
[[nodiscard]] Subject subject_of(UnknownKind kind, std::uint32_t owner, int axis);

}  // namespace collinea
