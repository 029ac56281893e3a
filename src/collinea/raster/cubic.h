// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "collinea/raster/raster.h"

namespace collinea {

/// Weights of the four samples around a position at phase i / 256: Catmull-Rom.
inline std::array<std::array<float, 4>, 257> cubic_weights() {
  std::array<std::array<float, 4>, 257> weights;
  for (int i = 0; i <= 256; ++i) {
    const double t = i / 256.0, t2 = t * t, t3 = t2 * t;
    weights[std::size_t(i)] = {float(-0.5 * t + t2 - 0.5 * t3), float(1 - 2.5 * t2 + 1.5 * t3),
                               float(0.5 * t + 2 * t2 - 1.5 * t3), float(-0.5 * t2 + 0.5 * t3)};
  }
  return weights;
}

/// The image between its samples, by cubic convolution, 1 to 255; 0 outside. x, y: in units of samples (sample
/// centres are whole numbers).
template <int kChannels>
[[nodiscard]] std::uint8_t cubic(const Raster<std::uint8_t>& image, float x, float y, int channel = 0) {
  static const auto kWeights = cubic_weights();
  if (!(x >= -0.5f && y >= -0.5f && x <= float(image.width) - 0.5f && y <= float(image.height) - 0.5f)) return 0;
  const int x0 = int(std::floor(x)), y0 = int(std::floor(y));
  const auto& wx = kWeights[std::size_t((x - float(x0)) * 256 + 0.5f)];
  const auto& wy = kWeights[std::size_t((y - float(y0)) * 256 + 0.5f)];
  float sum = 0;
  for (int j = 0; j < 4; ++j) {
    const std::uint8_t* row = image.row(std::clamp(y0 - 1 + j, 0, image.height - 1)) + channel;
    float across;
    if (x0 >= 1 && x0 + 2 < image.width) {
      const std::uint8_t* p = row + (x0 - 1) * kChannels;
      across = wx[0] * float(p[0]) + wx[1] * float(p[kChannels]) + wx[2] * float(p[2 * kChannels]) +
               wx[3] * float(p[3 * kChannels]);
    } else {
      across = 0;
      for (int i = 0; i < 4; ++i)
        across += wx[std::size_t(i)] * float(row[std::clamp(x0 - 1 + i, 0, image.width - 1) * kChannels]);
    }
    sum += wy[std::size_t(j)] * across;
  }
  return std::uint8_t(std::clamp(int(sum + 0.5f), 1, 255));
}

/// The same, bilinear.
template <int kChannels>
[[nodiscard]] std::uint8_t linear(const Raster<std::uint8_t>& image, float x, float y, int channel = 0) {
  if (!(x >= -0.5f && y >= -0.5f && x <= float(image.width) - 0.5f && y <= float(image.height) - 0.5f)) return 0;
  const float u = std::clamp(x, 0.0f, float(image.width - 1)), v = std::clamp(y, 0.0f, float(image.height - 1));
  const int x0 = int(u), y0 = int(v), x1 = std::min(x0 + 1, image.width - 1), y1 = std::min(y0 + 1, image.height - 1);
  const float a = u - float(x0), b = v - float(y0);
  const std::uint8_t *upper = image.row(y0) + channel, *lower = image.row(y1) + channel;
  const float above = (1 - a) * float(upper[x0 * kChannels]) + a * float(upper[x1 * kChannels]);
  const float below = (1 - a) * float(lower[x0 * kChannels]) + a * float(lower[x1 * kChannels]);
  return std::uint8_t(std::clamp(int((1 - b) * above + b * below + 0.5f), 1, 255));
}

}  // namespace collinea
