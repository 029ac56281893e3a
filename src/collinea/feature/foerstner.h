// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "collinea/raster/raster.h"

namespace collinea {

/// What the lines through the pixels meet in.
enum class FoerstnerModel {
  kCorner,  ///< lines along the edges: corners, junctions, chequerboards
  kCircle,  ///< lines across the edges: centres of discs and rings
};

/// Where the window stands.
enum class FoerstnerWindow {
  kFixed,      ///< around the start, as in the source: found again best among other texture. Of the error of the start
               ///< about a quarter stays
  kFollowing,  ///< around the point, until both stay: nothing draws the point to the start; for targets and crossings
};

struct FoerstnerPoint {
  Eigen::Vector2d position_px;
  Eigen::Matrix2d covariance_px2;  ///< by independent noise of the pixels, to first order
  double roundness = 0;            ///< q = 4 det N / trace^2 N
  double weight = 0;               ///< w = det N / trace N, of weights that sum to 1
  double misfit = 0;               ///< weighted mean square of gradient times distance from the lines
};

/// The point that is nearest to the lines through all pixels of a window, by least squares (Foerstner and Guelch 1987;
/// Mussio A.24): N x = sum w g g' p, N = sum w g g', with gradients g (derivatives of a Gaussian of 0.8 px) at pixels
/// p and Gaussian weights w of `sigma_px`. A window that follows the point (not in the source) takes away the pull of
/// noise and of blur towards its middle.
///
/// Covariance: the noise of the pixels (standard deviation noise_grey, independent) carried through gradients, normal
/// equations and, where they follow the point, weights: J^-1 C J^-T noise^2 with C from the derivative by every pixel
/// (docs/theory/interest.md). It is not scaled by the misfit, which is mostly form and not noise, and does not hold the
/// error of a start. A blurred corner of two edges is drawn to its inside by some tenths of a pixel, which is no noise.
///
/// Nothing: the window leaves the image, the edges have one direction (roundness < 0.01), the point runs off more than
/// 2 sigma_px from the start.
[[nodiscard]] std::optional<FoerstnerPoint> foerstner_point(const GreyImage& image, const Eigen::Vector2d& start_px,
                                                            double sigma_px, FoerstnerModel model,
                                                            FoerstnerWindow window, double noise_grey);

/// Standard deviation of the noise of a pixel [grey levels]: median of the absolute values of a second difference in
/// both directions (Immerkaer 1996, with the median in place of the mean), no less than that of rounding, 0.29. What
/// texture is finer than three pixels counts as noise. Images of less than 3 x 3 pixels: 0.29.
[[nodiscard]] double noise_of(const GreyImage& image);

}  // namespace collinea
