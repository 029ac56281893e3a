// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "collinea/image/raster.h"

namespace collinea {

/// Half the size, ceil(w / 2) x ceil(h / 2), every output pixel the rounded mean of the 2 x 2 pixels it covers (of
/// those that exist at an odd right or lower edge). A point at (x, y) of the input is at (x / 2, y / 2). Any channels.
[[nodiscard]] Raster<std::uint8_t> half(const Raster<std::uint8_t>& raster);

/// ceil(w / factor) x ceil(h / factor), every output pixel the rounded mean of the pixels it covers. Any channels.
[[nodiscard]] Raster<std::uint8_t> shrunk(const Raster<std::uint8_t>& raster, int factor);

/// Scaled to width x height by exact area averaging (each input pixel counts by its overlap); for downscaling, though
/// any size >= 1 is possible. A point at (x, y) is then at (x * width / raster.width, ...). Any channels.
[[nodiscard]] Raster<std::uint8_t> resized(const Raster<std::uint8_t>& raster, int width, int height);

/// Gaussian blur of standard deviation sigma_px > 0, separable, cut off at 4 sigma and normalised; the border pixel is
/// repeated outside. One channel. Below 0.05 px: the picture itself.
[[nodiscard]] FloatImage blurred(const FloatImage& raster, double sigma_px);

}  // namespace collinea
