// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "collinea/dense/internal/aggregate.h"
#include "collinea/dense/internal/disparity_costs.h"

namespace collinea::dense {

/// A rectangle of the left image that is matched on its own, and what of it counts: the rest is there so that its
/// border is nobody's border.
struct StereoTile {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;                      ///< ends excluded
  int kept_x0 = 0, kept_y0 = 0, kept_x1 = 0, kept_y1 = 0;  ///< likewise
};

/// Tiles that cover an image, so many that one has at most `max_elements` pixels times labels (these rounded up to
/// whole kLabelUnit), which is at least 144 x 144 pixels times that.
[[nodiscard]] std::vector<StereoTile> stereo_tiles(int width, int height, int labels, std::size_t max_elements);

/// What a change of disparity by one costs at each pixel: as Smoothness::small, on the scale of DisparityCosts.
[[nodiscard]] GreyImage small_changes(const GreyImage& left);

/// Semi-global aggregation along eight directions, the least sum and the parabola through it. Writes the disparities of
/// the kept part of the tile, NaN where left and right differ by more than `max_left_right_px` or the right image has
/// no such pixel. The rows are shared among run.threads threads, each a little behind the one above.
void match_tile(const DisparityCosts& costs, const GreyImage& left, int right_width, const GreyImage& small,
                const DisparityRange& range, int max_left_right_px, const StereoTile& tile, const Run& run,
                FloatImage& disparity);

}  // namespace collinea::dense
