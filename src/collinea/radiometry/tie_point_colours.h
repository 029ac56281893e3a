// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/base/run.h"
#include "collinea/block/block.h"
#include "collinea/raster/pixel_cache.h"

namespace collinea {

/// Gives every tie point the colour of its first image there, looked up at an eighth of the size of the image.
/// Observations are sorted by point, as everywhere. An image that cannot be read colours nothing. Error: cancelled.
[[nodiscard]] Result<> colour_tie_points(const PixelSource& pixels, Block& block, const Run& run);

}  // namespace collinea
