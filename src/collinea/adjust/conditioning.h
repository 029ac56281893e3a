// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "collinea/adjust/problem.h"
#include "collinea/math/tile_cholesky.h"

namespace collinea::bundle {

/// The unknown that a row of the reduced normal equations stands for: the attitude of an image, k1 of a camera.
[[nodiscard]] Subject subject_of_row(const Problem& problem, int row);

/// The worst combination of the reduced unknowns, by inverse iteration; `weights` is the diagonal of the normal
/// equations before the points were eliminated.
[[nodiscard]] Conditioning conditioning_of(const Problem& problem, const std::vector<double>& weights,
                                           const TileCholesky& factor, const Run& run);

}  // namespace collinea::bundle
