// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "collinea/base/run.h"
#include "collinea/surface/height_field.h"

namespace collinea {

/// How far the walls of a surface model are from where they should be, across the wall.
struct WallErrors {
  std::size_t samples = 0;         ///< looked at: a cell of the model along each wall
  double rms_m = 0, median_m = 0;  ///< the second: of the lengths
  double mean_m = 0;               ///< positive: what stands there is too wide
  double share_within = 0;         ///< of the samples, no farther off than two pixels of the ground
};

/// Walls are steps of the true surface of 2 m or more from one cell of the model to the next, with no other step within
/// 10 cells on either side. Across each, along the raster's axis that is nearer to its normal, the cells of the model
/// above half its height are counted within these 10 cells: what is too many or too few is its error, which is bounded
/// by that length. Samples with cells without a height are left out. `gsd_m`: of a pixel on the ground. Both rasters
/// lie on the same map. Errors: reading; cancelled.
[[nodiscard]] Result<WallErrors> wall_errors(const HeightField& model, const HeightField& truth, double gsd_m,
                                             const Run& run);

}  // namespace collinea
