// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <vector>

#include "collinea/block/block.h"

namespace collinea::bundle {

/// Approximate positions of points that have none, from those that have: set-ups by what they measured to two such
/// points or more (with azimuths to one), targets by direction, zenith angle and distance from a set-up, or by
/// directions and zenith angles of two, and the other end of a GNSS vector. `geodetic`: indices in Block::geodetic of
/// what is used.
void find_positions_by_geodetic(const Block& block, const std::vector<std::uint32_t>& geodetic,
                                std::map<ControlId, Eigen::Vector3d>& positions);

}  // namespace collinea::bundle
