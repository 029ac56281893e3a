// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <set>
#include <vector>

#include "collinea/quality/examine.h"

namespace collinea {

/// What an adjustment with covariances shows of its block: measurements on the ground that differ by more than chance
/// explains, worst first; lever arms, shifts, drifts, time offsets and boresights, and what of them can hardly be
/// separated; how many additional parameters are there for a reason; focal lengths that the images hardly determine,
/// with the cause, or that came out far from where they began. `first_cameras`: before any adjustment.
/// `excluded_geodetic`: indices in Block::geodetic of what was doubted before.
[[nodiscard]] std::vector<Finding> adjusted_findings(const Block& block, const Examined& adjusted,
                                                     const std::map<CameraId, Camera>& first_cameras,
                                                     const std::set<std::size_t>& excluded_geodetic);

}  // namespace collinea
