// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

namespace collinea {

/// An image in memory: rows of interleaved channels, upper row first, no padding.
/// The centre of the upper-left pixel is (0.5, 0.5) in continuous coordinates.
template <class T>
struct Raster {
  int width = 0, height = 0, channels = 1;
  std::vector<T> data;

  Raster() = default;
  Raster(int w, int h, int c = 1, T value = T{})
      : width(w), height(h), channels(c), data(std::size_t(w) * std::size_t(h) * std::size_t(c), value) {}

  [[nodiscard]] bool empty() const { return data.empty(); }
  [[nodiscard]] T* row(int y) { return data.data() + std::size_t(y) * std::size_t(width) * std::size_t(channels); }
  [[nodiscard]] const T* row(int y) const {
    return data.data() + std::size_t(y) * std::size_t(width) * std::size_t(channels);
  }
  [[nodiscard]] T& at(int x, int y, int c = 0) { return row(y)[x * channels + c]; }
  [[nodiscard]] const T& at(int x, int y, int c = 0) const { return row(y)[x * channels + c]; }
};

using GreyImage = Raster<std::uint8_t>;    ///< 1 channel
using ColourImage = Raster<std::uint8_t>;  ///< 3 channels: red, green, blue
using FloatImage = Raster<float>;

/// The value at a continuous position by bilinear interpolation, clamped at the border. x, y [px].
template <class T>
[[nodiscard]] float bilinear(const Raster<T>& raster, double x, double y, int channel = 0) {
  const double u = std::min(std::max(x - 0.5, 0.0), raster.width - 1.0);
  const double v = std::min(std::max(y - 0.5, 0.0), raster.height - 1.0);
  const int x0 = std::min(int(u), std::max(0, raster.width - 2)), y0 = std::min(int(v), std::max(0, raster.height - 2));
  const int x1 = std::min(x0 + 1, raster.width - 1), y1 = std::min(y0 + 1, raster.height - 1);
  const float a = float(u - x0), b = float(v - y0);
  const float top = (1 - a) * float(raster.at(x0, y0, channel)) + a * float(raster.at(x1, y0, channel));
  const float bottom = (1 - a) * float(raster.at(x0, y1, channel)) + a * float(raster.at(x1, y1, channel));
  return (1 - b) * top + b * bottom;
}

}  // namespace collinea
