// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "collinea/adjust/adjust_options.h"
#include "collinea/adjust/internal/candidates.h"

namespace collinea::bundle {

/// What takes part in an adjustment: all candidates, and which of them were too weak.
struct Participants {
  CandidateImages images;
  CandidatePoints points;                  ///< `geodetic` without what does not take part
  std::vector<bool> has_image, has_point;  ///< parallel to both: it takes part
  std::vector<ImageId> images_left_out;    ///< free, but with too few points
  std::size_t geodetic_left_out = 0;       ///< geodetic observations of points or shapes that take no part

  /// It takes part with a pose to be found.
  [[nodiscard]] bool is_unknown(std::size_t image) const { return has_image[image] && images.images[image].is_free; }
};

/// Points with too few rays, free images with too few points and geodetic observations of points that are not there
/// go, until all that remain have enough; in the end also fixed images without points.
[[nodiscard]] Participants reject_weak(const Block& block, CandidateImages images, CandidatePoints points);

/// Errors: no image is oriented, no point remains, or nothing of what remains has unknowns.
[[nodiscard]] Result<> check_there_is_something(const Participants& participants, const AdjustScope& scope,
                                                const AdjustOptions& options);

}  // namespace collinea::bundle
