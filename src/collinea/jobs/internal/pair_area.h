// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "collinea/jobs/internal/pair_steps.h"

namespace collinea {

/// A rectangle of the left image, from its upper-left to its lower-right corner, in pixels of the file (of film those
/// of the ideal image).
struct PairArea {
  Eigen::Vector2d least, most;

  [[nodiscard]] double pixels() const { return (most - least).prod(); }
};

/// The area of the options. Errors: not four numbers, a rectangle without pixels, nothing of it in the image.
[[nodiscard]] Result<std::optional<PairArea>> area_of(const PairChainOptions& options, const Camera& left);

/// The model with epipolar images of that area alone: of the left one the smallest rectangle that holds it, of the
/// right one what the disparities of the points there, and a third of their range beyond, can show of it. Only points
/// there are left in it. Error: fewer than eight of them.
[[nodiscard]] Result<ModelOfPair> cropped_to(const PairArea& area, ModelOfPair model);

}  // namespace collinea
