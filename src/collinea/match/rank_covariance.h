// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "collinea/match/area_matching.h"

namespace collinea {

/// The covariance [px^2] of the sub-pixel position of a match by rank or census. Both count which of two pixels is
/// darker, so that no residual and no derivative tells what noise does to them; it is tried (parametric bootstrap,
/// Efron 1979): noise of the size that the images have is added to the template and to the window round `pixel`, 64
/// times, and the extremum of the paraboloid is found anew. The covariance of these 64 positions is that of the match,
/// times 63/60: e' C^-1 e is then 2 in the mean although C is that of 64 trials (Wishart).
///
/// The noise is that of the correlation coefficient at the same pixel, sqrt(O / 2 (n - 4)), O being what gain and
/// offset of the template leave of the window at the extremum; rounding (0.29) at least. Where light differs in another
/// way than by gain and offset, which rank and census do not mind, that counts as noise: sigmas are then too large.
/// The random numbers are the same for each point. Cost: some 3 ms of 21 x 21 pixels.
///
/// Nothing: windows that leave their image, of another method, or where in more than a quarter of the trials there is
/// no extremum within a pixel: a peak that noise alone would lose.
[[nodiscard]] std::optional<Eigen::Matrix2d> rank_covariance(const GreyImage& image, const Eigen::Vector2i& middle,
                                                             int half, const GreyImage& other,
                                                             const Eigen::Vector2i& pixel, Similarity method,
                                                             int neighbourhood_px);

/// Gives a match of match_area() by rank or census this covariance; those of other measures have one.
void add_rank_covariance(const GreyImage& image, const Eigen::Vector2d& position_px, const GreyImage& other,
                         const AreaOptions& options, AreaMatching& matching);

}  // namespace collinea
