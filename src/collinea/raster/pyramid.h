// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "collinea/raster/raster.h"

namespace collinea {

/// Half the size, ceil(w / 2) x ceil(h / 2), every output pixel the rounded mean of the 2 x 2 pixels it covers (of
/// those that exist at an odd right or lower edge). A point at (x, y) of the input is at (x / 2, y / 2). Any channels.
[[nodiscard]] Raster<std::uint8_t> half(const Raster<std::uint8_t>& raster);

/// ceil(w / factor) x ceil(h / factor), every output pixel the rounded mean of the pixels it covers. Any channels.
[[nodiscard]] Raster<std::uint8_t> shrunk(const Raster<std::uint8_t>& raster, int factor);

}  // namespace collinea
