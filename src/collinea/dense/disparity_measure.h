// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/base/run.h"
#include "collinea/image/raster.h"

namespace collinea::dense {

/// Disparities measured again by correlation of 7 x 7 windows that follow a surface, at three places half a pixel
/// apart.
struct MeasuredDisparities {
  FloatImage disparity;    ///< at the parabola through the three correlations
  FloatImage sigma;        ///< standard deviation, from residuals and curvature [px]; infinite where there is no peak
  FloatImage correlation;  ///< there; 0 where a window is flat or has a hole
};
/// `surface`: disparities without NaN. Grey value 0 means "nothing there"; beyond the border pictures repeat.
[[nodiscard]] MeasuredDisparities measure(const GreyImage& left, const GreyImage& right, const FloatImage& surface,
                                          const Run& run);

/// The median of 3 x 3 pixels, then the mean over those of 5 x 5 that differ by at most `reach` from it. No NaN; beyond
/// the border pictures repeat.
[[nodiscard]] FloatImage smoothed(const FloatImage& surface, float reach, const Run& run);

}  // namespace collinea::dense
