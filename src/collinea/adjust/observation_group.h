// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/base/words.h"
#include "collinea/block/geodetic.h"

namespace collinea {

/// Kinds of observations, each with a sigma of its own that may be wrong. A new one is a line here and one in
/// kObservationGroupTraits, which says all that others ask of it.
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
  kAzimuth,
  kGnssVector,
  kAttitudeLevel,
  kAttitudeHeading,
};
inline constexpr std::size_t kObservationGroups = static_cast<std::size_t>(ObservationGroup::kAttitudeHeading) + 1;

/// Where an observation is given, and by what it is found there.
enum class ObservationSource : std::uint8_t {
  kTieImagePoint,       ///< index in Block::observations
  kControlImagePoint,   ///< index in Block::control_observations
  kControlCoordinates,  ///< ControlId, in Block::control
  kPosition,            ///< ImageId: Image::position
  kGeodetic,            ///< index in Block::geodetic
  kAttitude,            ///< ImageId, in AdjustScope::attitudes
};

/// What a group of observations is.
struct ObservationGroupTraits {
  ObservationGroup group{};
  std::string_view word;  ///< that names it in records
  ObservationSource source{};
  /// The coordinates of its measurement that are of this group: 0 column or east, 1 row or north, 2 height; of
  /// attitudes the axes of the rotation. They share a sigma and are rejected together. What has one value has it on 0.
  int first_axis = 0, axes = 1;
  bool is_angle = false;  ///< in [rad]; others in [m], or [px] in images
};

inline constexpr std::array<ObservationGroupTraits, kObservationGroups> kObservationGroupTraits = {{
    {ObservationGroup::kTieImages, "tie_images", ObservationSource::kTieImagePoint, 0, 2},
    {ObservationGroup::kControlImages, "control_images", ObservationSource::kControlImagePoint, 0, 2},
    {ObservationGroup::kControlPlan, "control_plan", ObservationSource::kControlCoordinates, 0, 2},
    {ObservationGroup::kControlHeight, "control_height", ObservationSource::kControlCoordinates, 2, 1},
    {ObservationGroup::kPositionPlan, "position_plan", ObservationSource::kPosition, 0, 2},
    {ObservationGroup::kPositionHeight, "position_height", ObservationSource::kPosition, 2, 1},
    {ObservationGroup::kDistance, "distance", ObservationSource::kGeodetic},
    {ObservationGroup::kHeightDifference, "height_difference", ObservationSource::kGeodetic},
    {ObservationGroup::kDirection, "direction", ObservationSource::kGeodetic, 0, 1, true},
    {ObservationGroup::kZenithAngle, "zenith_angle", ObservationSource::kGeodetic, 0, 1, true},
    {ObservationGroup::kAtHeight, "at_height", ObservationSource::kGeodetic},
    {ObservationGroup::kOnPlane, "on_plane", ObservationSource::kGeodetic},
    {ObservationGroup::kOnLine, "on_line", ObservationSource::kGeodetic},
    {ObservationGroup::kAzimuth, "azimuth", ObservationSource::kGeodetic, 0, 1, true},
    {ObservationGroup::kGnssVector, "gnss_vector", ObservationSource::kGeodetic},
    {ObservationGroup::kAttitudeLevel, "attitude_level", ObservationSource::kAttitude, 0, 2, true},
    {ObservationGroup::kAttitudeHeading, "attitude_heading", ObservationSource::kAttitude, 2, 1, true},
}};

[[nodiscard]] constexpr const ObservationGroupTraits& traits_of(ObservationGroup group) {
  return kObservationGroupTraits[static_cast<std::size_t>(group)];
}

static_assert(is_in_order(kObservationGroupTraits, kObservationGroups, &ObservationGroupTraits::group),
              "the traits stand in the order of the groups");

inline constexpr std::array<Word<ObservationGroup>, kObservationGroups> kObservationGroupWords = [] {
  std::array<Word<ObservationGroup>, kObservationGroups> table{};
  for (std::size_t g = 0; g < kObservationGroups; ++g)
    table[g] = {kObservationGroupTraits[g].group, kObservationGroupTraits[g].word};
  return table;
}();
[[nodiscard]] constexpr std::span<const Word<ObservationGroup>> words(ObservationGroup) {
  return kObservationGroupWords;
}
static_assert(
    [] {
      for (const ObservationGroupTraits& its : kObservationGroupTraits)
        if (its.word.empty() || from_word<ObservationGroup>(its.word) != its.group) return false;
      return true;
    }(),
    "every group has a word of its own");

/// The group of a coordinate of what a source gives: `axis` as in ObservationGroupTraits. Not of geodetic observations,
/// whose groups are of their kinds.
[[nodiscard]] constexpr ObservationGroup group_of(ObservationSource source, int axis) {
  if (source == ObservationSource::kGeodetic) bug("the group of a geodetic observation is that of its kind");
  for (const ObservationGroupTraits& its : kObservationGroupTraits)
    if (its.source == source && axis >= its.first_axis && axis < its.first_axis + its.axes) return its.group;
  bug("a coordinate without a group");
}

/// The groups of a source, in their order.
[[nodiscard]] inline std::vector<ObservationGroup> groups_of(ObservationSource source) {
  std::vector<ObservationGroup> groups;
  for (const ObservationGroupTraits& its : kObservationGroupTraits)
    if (its.source == source) groups.push_back(its.group);
  return groups;
}

static_assert(
    [] {
      for (const ObservationGroupTraits& its : kObservationGroupTraits)
        for (int axis = its.first_axis; axis < its.first_axis + its.axes; ++axis)
          if (its.source != ObservationSource::kGeodetic && group_of(its.source, axis) != its.group) return false;
      return true;
    }(),
    "a coordinate is of one group");

/// Angles, in [rad].
[[nodiscard]] constexpr bool is_angle(ObservationGroup group) { return traits_of(group).is_angle; }

/// Image coordinates, in [px], of tie points and of control.
[[nodiscard]] constexpr bool is_image_point(ObservationGroup group) {
  const ObservationSource source = traits_of(group).source;
  return source == ObservationSource::kTieImagePoint || source == ObservationSource::kControlImagePoint;
}

/// The group of a geodetic observation.
[[nodiscard]] constexpr ObservationGroup group_of(GeodeticKind kind) {
  return static_cast<ObservationGroup>(static_cast<std::size_t>(ObservationGroup::kDistance) +
                                       static_cast<std::size_t>(kind));
}

}  // namespace collinea
