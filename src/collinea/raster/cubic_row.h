// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "collinea/raster/raster.h"

namespace collinea {

/// The image (1 or 3 channels) at `count` positions as cubic() reads it, the same bits; many at once. x, y: in units of
/// samples, NaN: nothing there. `out` has count pixels.
void cubic_row(const Raster<std::uint8_t>& image, const float* x, const float* y, int count, std::uint8_t* out);

}  // namespace collinea
