// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "collinea/raster/raster.h"

namespace collinea {

/// Which of the neighbours within `half` columns and rows (1 to 3) of a pixel are darker: a bit each, row by row, the
/// first in the highest (census); their number is the rank of the pixel (Zabih and Woodfill 1994). Beyond the border
/// counts the nearest pixel.
[[nodiscard]] std::uint64_t darker_neighbours(const GreyImage& image, int column, int row, int half);

}  // namespace collinea
