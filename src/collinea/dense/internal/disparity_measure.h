// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/base/run.h"
#include "collinea/dense/internal/disparity_map.h"
#include "collinea/dense/internal/measure_kernels.h"

namespace collinea::dense {

/// Disparities measured again by correlation of 7 x 7 windows that follow a surface, at three positions half a pixel
/// apart: at the parabola through the three correlations, drawn to the surface; their standard deviations from
/// residuals and curvature. NaN where `found` is, where the windows are flat or have holes, and what is not accepted.
/// `surface`: disparities without NaN. Grey value 0 means "nothing there"; beyond the border images repeat.
[[nodiscard]] DisparityMap measure(const GreyImage& left, const GreyImage& right, const FloatImage& surface,
                                   const FloatImage& found, const Acceptance& acceptance, const Run& run);

/// A row of fill_disparities().
void fill_row(const float* found, int width, float* filled);

/// Holes filled by fill_row(), 0 in rows with nothing at all; the median of 3 x 3 pixels, then the mean
/// over those of 5 x 5 that differ by at most `reach` from it. Beyond the border images repeat.
[[nodiscard]] FloatImage smooth_surface(const FloatImage& found, float reach, const Run& run);

}  // namespace collinea::dense
