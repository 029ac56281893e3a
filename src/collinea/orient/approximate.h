// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/block/block.h"
#include "collinea/epipolar/robust_start.h"

namespace collinea {

/// What was found for a block that came without.
struct Approximation {
  std::vector<ImageId> resected;  ///< images that had no pose
  int intersected = 0;            ///< tie points, and marked points, that had no coordinates
  std::vector<ImageId>
      without_pose;  ///< nothing determines them; with fewer than four measured points, or these on a line
  std::vector<PointId> without_position;  ///< measured in fewer than two oriented images, or along nearly parallel rays
  std::vector<ControlId> marked_without_position;  ///< the same of control points that have no coordinates
};

/// Finds approximate poses and coordinates where they are missing: images are resected from control and from tie points
/// that are known, tie points and control points without coordinates (these for resection alone: adjustment intersects
/// them itself) are intersected from oriented images, the best determined image first, until nothing more is found. By
/// kTruncated measurements count as wrong beyond a tenth of the image's width, which a lens that is known badly may
/// leave; by kLeastMedian and kL1 the errors of an image themselves tell, of which nearly half may be gross
/// (robust_start()). Errors: kIllPosed when no image has a pose and none can be resected.
[[nodiscard]] Result<Approximation> approximate(Block& block, std::uint64_t seed,
                                                RobustStart start = RobustStart::kTruncated);

}  // namespace collinea
