// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "collinea/adjust/problem.h"
#include "collinea/math/tile_cholesky.h"

namespace collinea::bundle {

/// "the attitude of IMG_3.jpg", "k1 of camera X": what a row of the reduced normal equations stands for.
[[nodiscard]] std::string name_of_unknown(const Block& block, const Problem& problem, int row);

/// The worst combination of the reduced unknowns, by inverse iteration; `weights` is the diagonal of the normal
/// equations before the points were eliminated.
[[nodiscard]] Conditioning conditioning_of(const Block& block, const Problem& problem,
                                           const std::vector<double>& weights, const TileCholesky& factor,
                                           const Run& run);

}  // namespace collinea::bundle
