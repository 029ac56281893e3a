// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "collinea/dense/internal/row_correlation.h"
#include "collinea/dense/level_point.h"
#include "collinea/raster/raster.h"

namespace collinea {

/// Disparities and rows in which a window of the left image is looked for in the right one.
struct ShapedSearch {
  double low_px = 0, high_px = 0;  ///< disparities of its middle
  int rows = 0;                    ///< on either side
  double return_px = 1.5;          ///< so near must the match, looked for backwards, come to its pixel
};

/// The search for the match of a window of 2 half + 1 pixels round a pixel of the left image, under any number of
/// gradients of disparity of the surface that it shows. The images must outlive it.
class ShapedMatcher {
 public:
  ShapedMatcher(const GreyImage& left, const Eigen::Vector2i& pixel, int half, const GreyImage& right,
                const ShapedSearch& search);

  /// The best match by the correlation coefficient of windows that are squares of the right image: the left one is
  /// resampled along its rows (cubic) as the gradient says. There and back again; nothing as best_correlation(), or
  /// when it does not come back.
  [[nodiscard]] std::optional<LevelPoint> match(const Eigen::Vector2d& gradient) const;

 private:
  const GreyImage &left_, &right_;
  Eigen::Vector2i pixel_;
  int half_;
  double return_px_;
  SearchedBand there_, back_;
};

/// A match that is good enough, measured by fitted_plane(), when it still is after that.
[[nodiscard]] std::optional<LevelPoint> measured_match(const GreyImage& left, int half, const GreyImage& right,
                                                       const std::optional<LevelPoint>& found, double min_ncc);

/// The match by least squares: the plane of the disparities d + gradient . (u, v) of the window and gain and offset of
/// its grey values,
///     left(u, v) = offset + gain right(x + u - d - gradient . (u, v), y + row + v),
/// so that the disparity is that of the middle of the window, whatever its slope and wherever its texture lies. Sigma:
/// from residuals and normal matrix, with residuals of neighbours as alike as they are. Nothing when it does not settle
/// within a pixel of the start, or is steeper than 1 px a pixel, or where the window leaves an image.
[[nodiscard]] std::optional<LevelPoint> fitted_plane(const GreyImage& left, int half, const GreyImage& right,
                                                     const LevelPoint& start);

}  // namespace collinea
