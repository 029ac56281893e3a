// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "collinea/surface/height_interpolation.h"

namespace collinea {

/// The covariance that makes heights less their trend (parallel to the points) most likely, beginning at `start`, of
/// its model: signal, range and noise by the likelihood of Vecchia (1988), a product of the densities of each point
/// given the 14 nearest of those before it in a random order (400 points at most, evenly taken). The points' own sigmas
/// are in it, so that noise is what they do not explain; a hundred-millionth of the heights' mean square or less is
/// none. Unlike a variogram, whose first class reaches a fiftieth of the extent, it uses the nearest points one by one:
/// noise is told from a short range, and a smooth surface has none.
struct LikelyCovariance {
  HeightCovariance covariance;
  double minus_log_likelihood = 0;  ///< infinite: the heights are all on their trend, or no covariance is regular
};
[[nodiscard]] LikelyCovariance most_likely(std::span<const HeightPoint> points, std::span<const double> heights,
                                           const HeightCovariance& start, double least_range_m, double most_range_m);

}  // namespace collinea
