// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <functional>
#include <map>
#include <vector>

#include "collinea/adjust/adjust_scope.h"
#include "collinea/adjust/internal/problem.h"
#include "collinea/base/result.h"
#include "collinea/block/block.h"

namespace collinea::bundle {

/// A coordinate that counts must be a number; one that was not given (its sigma is infinite) need not.
[[nodiscard]] inline bool known(double coordinate, double sigma) {
  return std::isfinite(coordinate) || std::isinf(sigma);
}

/// Places in Block::ground of what may take part: all of it, but nothing in a local adjustment. Errors: values that are
/// no numbers, sigmas not positive, a point measured against itself.
[[nodiscard]] Result<std::vector<std::uint32_t>> ground_taking_part(const Block& block, const AdjustScope& scope);

/// Takes those out that say nothing, because the points of their shape that take part do not determine it and one more.
void erase_weak_shapes(const Block& block, const std::function<Eigen::Vector3d(ControlId)>& place_of,
                       std::vector<std::uint32_t>& links);

/// How many unknowns of each point the links can determine, if it takes part: each counts once, but of the directions
/// of a set-up on the point one finds its orientation, and a single direction of a set-up says nothing. Points that no
/// link has are not there.
[[nodiscard]] std::map<ControlId, int> ground_counts(const Block& block, const std::vector<std::uint32_t>& links);

/// Approximate places of points that have none, from those that have: set-ups by what they measured to two such points
/// or more, targets by direction, zenith angle and distance from a set-up, or by directions and zenith angles of two.
void find_positions_by_geodetic(const Block& block, const std::vector<std::uint32_t>& links,
                                std::map<ControlId, Eigen::Vector3d>& places);

/// Points that are measured between get their unknowns in the border, behind all others. Directions of one set-up have
/// its orientation in common, which begins with what the first of them says; points of one shape that of their best
/// fit.
void lay_out_ground(const Block& block, const std::vector<std::uint32_t>& links, ProblemAndStart& out);

/// Positions, attitudes and verticals of the free images, with the unknowns of their instruments. Errors as adjust().
[[nodiscard]] Result<> take_instruments(const Block& block, const AdjustScope& scope, ProblemAndStart& out);

}  // namespace collinea::bundle
