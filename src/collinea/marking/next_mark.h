// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "collinea/quality/marked_points.h"

namespace collinea {

/// A mark that could be made: where an image is predicted to show a point.
struct PossibleMark {
  std::size_t point = 0;  ///< of the points that are marked
  BlockMark mark;
};

/// What a mark would do for all points together.
struct NextMark {
  PossibleMark mark;
  std::size_t placed_before = 0, placed_after = 0;  ///< points that have a position
  /// Root mean square of the standard deviations of the coordinates of those placed before; 0: there are none.
  double rms_sigma_before_m = 0, rms_sigma_after_m = 0;
};

/// Of marks that could be made the one that helps the points of a block most: it places most of them, and of those
/// that place equally many makes the standard deviations of all that have a position smallest. Standard deviations do
/// not ask what will be measured, so that each mark can be tried before it is made. The block is brought up to date
/// once for each. Nothing where there is no mark to make, or none that the block takes. Errors: those of
/// MarkedBlock::adjust() for the marks that there are. `ground`: what was measured on the ground between the points.
[[nodiscard]] Result<std::optional<NextMark>> best_next_mark(MarkedBlock& block, std::span<const BlockPoint> points,
                                                             std::span<const PossibleMark> possible,
                                                             std::span<const PointLink> ground = {});

}  // namespace collinea
