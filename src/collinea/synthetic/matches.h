// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <vector>

#include "collinea/block/block.h"
#include "collinea/block/features.h"
#include "collinea/synthetic/internal/truth.h"

namespace collinea {

/// What detection and matching would hand on, without images and descriptors.
struct SimulatedMatches {
  std::map<ImageId, std::vector<Keypoint>> keypoints;  ///< in the order of Observation::feature
  std::vector<ImagePair> pairs;                        ///< sorted; putative matches only, geometry not yet looked at
};

/// Keypoints and putative matches of a block made by observations_only. Two images that found the same point match it
/// with the chance matched_share; a match is wrong with the chance wrong_share: it then leads to the feature next to
/// the epipolar line, as those do that verification lets pass. Pairs with fewer than `least_matches` are left out.
[[nodiscard]] SimulatedMatches simulated_matches(const Block& block, const ObservationOptions& options,
                                                 std::size_t least_matches, const Run& run);

}  // namespace collinea
