// SPDX-License-Identifier: Apache-2.0
#include "collinea/dense/internal/texture_centroid.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "collinea/dense/internal/match_kernels.h"

namespace collinea::dense {
namespace {

constexpr float kFarthestPx = float(kRadius) / 2;

// Squared differences between four pixels, at their common corner: that of x, y and x + 1, y + 1.
FloatImage squared_differences(const GreyImage& image) {
  FloatImage result(image.width, image.height, 1, 0);
  const auto square = [](int difference) { return float(difference * difference); };
  for (int y = 0; y + 1 < image.height; ++y) {
    const std::uint8_t *a = image.row(y), *b = image.row(y + 1);
    float* out = result.row(y);
    for (int x = 0; x + 1 < image.width; ++x)
      if (a[x] && a[x + 1] && b[x] && b[x + 1])
        out[x] = square(a[x + 1] - a[x]) + square(b[x + 1] - b[x]) + square(b[x] - a[x]) + square(b[x + 1] - a[x + 1]);
  }
  return result;
}

}  // namespace

bool TextureCentroid::is_aside(int x, int y) const {
  const float i = right.at(x, y), j = down.at(x, y);
  return !(i * i + j * j <= kFarthestPx * kFarthestPx);
}

TextureCentroid texture_centroid(const GreyImage& image) {
  const int width = image.width, height = image.height;
  const FloatImage texture = squared_differences(image);
  // Sums along rows first; a window has six corners from k = -3 to 2, each k + 0.5 from its middle.
  FloatImage sum(width, height, 1, 0), moment(width, height, 1, 0);
  for (int y = 0; y < height; ++y)
    for (int k = -kRadius; k < kRadius; ++k) {
      const float *in = texture.row(y), at = float(k) + 0.5f;
      float *s = sum.row(y), *m = moment.row(y);
      for (int x = std::max(0, -k); x < std::min(width, width - k); ++x) {
        s[x] += in[x + k];
        m[x] += at * in[x + k];
      }
    }
  TextureCentroid centroid{FloatImage(width, height, 1, 0), FloatImage(width, height, 1, 0)};
  std::vector<float> whole(std::size_t(width), 0);
  for (int y = 0; y < height; ++y) {
    std::fill(whole.begin(), whole.end(), 0);
    float *right = centroid.right.row(y), *down = centroid.down.row(y);
    for (int k = std::max(-kRadius, -y); k < std::min(kRadius, height - y); ++k) {
      const float *s = sum.row(y + k), *m = moment.row(y + k), at = float(k) + 0.5f;
      for (int x = 0; x < width; ++x) {
        whole[std::size_t(x)] += s[x];
        right[x] += m[x];
        down[x] += at * s[x];
      }
    }
    for (int x = 0; x < width; ++x) {
      right[x] /= whole[std::size_t(x)];
      down[x] /= whole[std::size_t(x)];
    }
  }
  return centroid;
}

void keep_textured(const TextureCentroid& centroid, float reach, FloatImage& surface) {
  const int width = surface.width, height = surface.height;
  const auto goes_on = [&](int x, int y, float w) {
    const float right = centroid.right.at(x, y), down = centroid.down.at(x, y);
    if (std::isnan(right)) return false;
    const float away = float(kRadius + 1) / std::hypot(right, down);
    const int u = x - int(std::lround(right * away)), v = y - int(std::lround(down * away));
    for (int j = std::max(v - 1, 0); j <= std::min(v + 1, height - 1); ++j)
      for (int i = std::max(u - 1, 0); i <= std::min(u + 1, width - 1); ++i)
        if (!centroid.is_aside(i, j) && std::abs(surface.at(i, j) - w) <= reach) return true;
    return false;
  };
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      float& w = surface.at(x, y);
      if (!std::isnan(w) && centroid.is_aside(x, y) && !goes_on(x, y, w)) w = std::numeric_limits<float>::quiet_NaN();
    }
}

}  // namespace collinea::dense
