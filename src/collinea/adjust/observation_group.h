// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "collinea/block/ground.h"

namespace collinea {

/// Kinds of observations, each with a sigma of its own that may be wrong.
enum class ObservationGroup {
  kTieImages,
  kControlImages,
  kControlPlan,
  kControlHeight,
  kPositionPlan,
  kPositionHeight,
  kDistance,
  kHeightDifference,
  kDirection,
  kZenithAngle,
  kAtHeight,
  kOnPlane,
  kOnLine,
  kAttitudeLevel,
  kAttitudeHeading,
};
inline constexpr std::size_t kObservationGroups = 15;

/// Angles, in [rad].
[[nodiscard]] constexpr bool is_angle(ObservationGroup group) {
  return group == ObservationGroup::kDirection || group == ObservationGroup::kZenithAngle ||
         group >= ObservationGroup::kAttitudeLevel;
}

/// The group of a measurement on the ground.
[[nodiscard]] constexpr ObservationGroup group_of(GeodeticKind kind) {
  return static_cast<ObservationGroup>(static_cast<std::size_t>(ObservationGroup::kDistance) +
                                       static_cast<std::size_t>(kind));
}

}  // namespace collinea
