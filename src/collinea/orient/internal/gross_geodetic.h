// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <set>
#include <vector>

#include "collinea/base/finding.h"
#include "collinea/block/block.h"

namespace collinea {

/// Geodetic observations that cannot be where a block lies.
struct GrossGeodetic {
  std::vector<std::size_t> excluded;  ///< indices in Block::geodetic
  std::vector<Finding> findings;
};

/// Distances, height differences, directions, azimuths and zenith angles that contradict a block that lies in the
/// world: slips of a digit, a sign or a unit, which would take the adjustment along. Both points are intersected from
/// two images and more. What is off by `part` of the line between them, as a length or across it, and by five standard
/// deviations of the measurement and the two points, is gross; what is less is left to the tests of the adjustment.
/// Directions count from the zero that the most of their set-up agree with.
[[nodiscard]] GrossGeodetic gross_geodetic(const Block& block, double part);

/// To what part of a line a block in the world knows it: by control a two-hundredth at best, and ten standard
/// deviations of these points over their extent; by positions (fewer than three points of `control`) a tenth at best,
/// and five times `rotation_rad`, the standard deviation of its attitude and scale by them. A block that knows less
/// than a measurement must not judge it.
[[nodiscard]] double known_part(const Block& block, const std::set<ControlId>& control, double rotation_rad);

}  // namespace collinea
