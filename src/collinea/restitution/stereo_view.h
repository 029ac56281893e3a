// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <utility>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/geodesy/local_frame.h"
#include "collinea/marking/marking_block.h"
#include "collinea/restitution/map_height.h"
#include "collinea/restitution/stereo_geometry.h"
#include "collinea/restitution/stereo_pairs.h"

namespace collinea {

/// What a person wants to see in stereo: a place of the map, two photographs, or the place in these.
struct AskedStereo {
  std::optional<Eigen::Vector2d> on_map;
  std::optional<std::pair<ImageId, ImageId>> images;
};

/// A pair with the mark at the place.
struct StereoView {
  StereoGeometry model;
  StereoMark mark;
  Eigen::Vector3d position_in_world;  ///< where the mark is
  StereoChoice shown;                 ///< of this pair
  std::vector<StereoChoice> choices;  ///< all that show the place, best first (stereo_choices())
  PixelLattice left, right;
  MapPolynomial map;  ///< about the place, as far as the photographs see (at most 5 km)
};

/// The best pair for a place, or the two photographs named, with the mark at the height of the surface there, else at
/// the median height of the kNearTies tie points nearest in plan. Of photographs alone the place is the tie point of
/// both that is nearest to the middle of those that they share. `frame`: null where the map is the world. Errors:
/// kBadInput, neither place nor images; kIllPosed, not oriented, no pair shows the place, no tie points; those of
/// StereoGeometry::of() and pixel_lattice().
[[nodiscard]] Result<StereoView> stereo_view(const MarkingBlock& block, const LocalFrame* frame,
                                             const MapHeight& surface, const AskedStereo& asked);
inline constexpr std::size_t kNearTies = 9;

}  // namespace collinea
