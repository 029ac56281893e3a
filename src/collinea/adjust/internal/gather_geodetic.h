// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
#include <set>
#include <vector>

#include "collinea/adjust/adjust_scope.h"
#include "collinea/adjust/internal/problem.h"
#include "collinea/base/result.h"
#include "collinea/block/block.h"

namespace collinea::bundle {

// The table of geodetic observations. `geodetic`: indices in Block::geodetic of those that take part.

/// Indices of what may take part: all of it, but nothing in a local adjustment. Errors: values that are no numbers,
/// sigmas not positive, a point measured against itself.
[[nodiscard]] Result<std::vector<std::uint32_t>> geodetic_taking_part(const Block& block, const AdjustScope& scope);

/// The points that they are of.
[[nodiscard]] std::set<ControlId> points_of(const Block& block, const std::vector<std::uint32_t>& geodetic);

/// Erases those that say nothing, because the points of their shape that take part do not determine it and one more.
void erase_weak_shapes(const Block& block, const std::function<Eigen::Vector3d(ControlId)>& position_of,
                       std::vector<std::uint32_t>& geodetic);

/// How many unknowns of each point the observations can determine, if it takes part: each counts once, but of the
/// directions of a set-up on the point one finds its orientation, and a single direction of a set-up says nothing.
/// Points without observations are not there.
[[nodiscard]] std::map<ControlId, int> geodetic_counts(const Block& block, const std::vector<std::uint32_t>& geodetic);

/// Fills Problem::geodetic. Points that observations are of get their unknowns among the global parameters, behind all
/// others. Directions of one set-up have its orientation in common, which begins with what the first of them says;
/// points of one shape that of their best fit.
void lay_out_geodetic(const Block& block, const std::vector<std::uint32_t>& geodetic, ProblemAndStart& out);

}  // namespace collinea::bundle
