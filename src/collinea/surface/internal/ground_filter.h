// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "collinea/base/run.h"
#include "collinea/raster/raster.h"

namespace collinea {

/// Which cells of a grid of low heights [m] show the ground: 1, otherwise 0. NaN: nothing known, never ground.
///
/// Openings (erosion, then dilation) with squares that grow up to `largest_object_m` take everything from the surface
/// that is narrower than the square; what loses more than the square's half width times a slope of 0.15 stands on the
/// ground (simple morphological filter: Pingel, Clarke, McBride, ISPRS Journal 77, 2013; progressive: Zhang et al.,
/// IEEE TGRS 41, 2003). Two things are ours: heights far below all around them are no ground either, and what an
/// opening took away is given back when most of its rim has no step: a hill top or a steep bank, not an object.
/// The same for any number of threads.
[[nodiscard]] Raster<std::uint8_t> ground_cells(const FloatImage& low_m, double cell_m, double largest_object_m,
                                                const Run& run);

/// Every value becomes the smallest (largest) of the square of 2 * radius + 1 cells around it, as far as it lies in the
/// raster.
[[nodiscard]] FloatImage smallest_around(FloatImage heights, int radius, const Run& run);
[[nodiscard]] FloatImage largest_around(FloatImage heights, int radius, const Run& run);

}  // namespace collinea
