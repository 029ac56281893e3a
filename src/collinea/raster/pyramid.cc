// SPDX-License-Identifier: Apache-2.0
#include "collinea/raster/pyramid.h"

#include <algorithm>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/raster/internal/pyramid_kernels.h"

namespace collinea {
Raster<std::uint8_t> half(const Raster<std::uint8_t>& raster) {
  if (raster.channels != 1 && raster.channels != 3) return shrunk(raster, 2);
  const int width = (raster.width + 1) / 2, height = (raster.height + 1) / 2, channels = raster.channels;
  Raster<std::uint8_t> out(width, height, channels);
  for (int y = 0; y < height; ++y) {
    const std::uint8_t* upper = raster.row(2 * y);
    const std::uint8_t* lower = raster.row(std::min(2 * y + 1, raster.height - 1));
    halve_rows(upper, lower, out.row(y), raster.width / 2, channels);
    for (int c = 0; raster.width % 2 == 1 && c < channels; ++c) {
      const int last = (raster.width - 1) * channels + c;
      out.at(width - 1, y, c) = std::uint8_t((upper[last] + lower[last] + 1) >> 1);
    }
  }
  return out;
}

Raster<std::uint8_t> shrunk(const Raster<std::uint8_t>& raster, int factor) {
  COLLINEA_CHECK(factor >= 1 && factor <= 4096);
  const int channels = raster.channels, width = (raster.width + factor - 1) / factor;
  Raster<std::uint8_t> out(width, (raster.height + factor - 1) / factor, channels);
  std::vector<std::uint32_t> sums(std::size_t(width) * std::size_t(channels));
  for (int y = 0; y < out.height; ++y) {
    std::fill(sums.begin(), sums.end(), 0u);
    const int top = y * factor, bottom = std::min(top + factor, raster.height);
    for (int row = top; row < bottom; ++row) {
      const std::uint8_t* in = raster.row(row);
      for (int x = 0; x < raster.width; ++x)
        for (int c = 0; c < channels; ++c) sums[std::size_t(x / factor * channels + c)] += in[x * channels + c];
    }
    for (int x = 0; x < width; ++x) {
      const std::uint32_t count =
          std::uint32_t((bottom - top) * (std::min((x + 1) * factor, raster.width) - x * factor));
      for (int c = 0; c < channels; ++c)
        out.at(x, y, c) = std::uint8_t((sums[std::size_t(x * channels + c)] + count / 2) / count);
    }
  }
  return out;
}

}  // namespace collinea
