// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "collinea/dense/level_point.h"
#include "collinea/raster/raster.h"

namespace collinea {

/// Disparities and rows in which a window of the left image is looked for in the right one.
struct ShapedSearch {
  double low_px = 0, high_px = 0;  ///< disparities of its middle
  int rows = 0;                    ///< on either side
  Eigen::Vector2d gradient = {0, 0};
  double return_px = 1.5;  ///< so near must the match, looked for backwards, come to its pixel
};

/// The best match of the window of 2 half + 1 pixels round a pixel of the left image by the correlation coefficient,
/// when the surface it shows has that gradient of disparity: the right image is resampled along its rows (cubic) so
/// that the window stays a square. There and back again; nothing as best_correlation(), or when it does not come back.
[[nodiscard]] std::optional<LevelPoint> match_shaped(const GreyImage& left, const Eigen::Vector2i& pixel, int half,
                                                     const GreyImage& right, const ShapedSearch& search);

/// The match by least squares: the plane of the disparities d + gradient . (u, v) of the window and gain and offset of
/// its grey values,
///     left(u, v) = offset + gain right(x + u - d - gradient . (u, v), y + row + v),
/// so that the disparity is that of the middle of the window, whatever its slope and wherever its texture lies. Sigma:
/// from residuals and normal matrix, with residuals of neighbours as alike as they are. Nothing when it does not settle
/// within a pixel of the start, or is steeper than 1 px a pixel, or where the window leaves an image.
[[nodiscard]] std::optional<LevelPoint> fitted_plane(const GreyImage& left, int half, const GreyImage& right,
                                                     const LevelPoint& start);

}  // namespace collinea
