// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "collinea/quality/examine.h"
#include "collinea/quality/internal/rejected.h"

namespace collinea {

/// An adjustment that may be bent by gross errors, beside one that they cannot bend.
struct GrossErrors {
  /// What contradicts the others grossly: its name, by how much, and its given sigma; the largest first. Which of
  /// several is wrong is not asked (snoop() does). Where half of the coordinates contradict the others it is all of
  /// them.
  std::vector<Rejected> measurements;
  long lost_rays = 0;  ///< image points of others whose point lies where the adjustment lets their image not see it
  long rays = 0;       ///< all that took part
};

/// True when the tests of an adjustment cannot be believed, because a gross error may have bent it beyond what linear
/// equations describe: it has failed, has not converged, leaves something undetermined or points where their images do
/// not see them, or an observation on the ground misses it by twenty of its
/// standard deviations, in an image by a thousand.
[[nodiscard]] bool is_bent(const Result<Examined>& adjusted, const TestOptions& options);

/// Looks for gross errors by a robust fit (robust_fit()), and for what an adjustment lost that has none; `adjusted`:
/// that adjustment of the block, null when it failed. Cost: up to nine adjustments.
[[nodiscard]] GrossErrors find_gross_errors(const Block& block, const AdjustScope& scope, const AdjustOptions& options,
                                            const Adjusted* adjusted, const Run& run);

}  // namespace collinea
