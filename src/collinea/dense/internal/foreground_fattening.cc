// SPDX-License-Identifier: Apache-2.0
#include "collinea/dense/internal/foreground_fattening.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "collinea/base/parallel.h"
#include "collinea/dense/internal/match_kernels.h"

namespace collinea::dense {
namespace {

constexpr int kHalfWindow = kRadius;      // of matching: how far the fattening reaches
constexpr int kAround = 2 * kHalfWindow;  // as much again beyond the fattened border shows what surely lies in front
constexpr int kFewest = 5;                // pixels in front, and behind
constexpr float kAlike = 10;              // grey values: above the noise of images, below what makes an edge
constexpr int kStripRows = 32;

using Mask = Raster<std::uint8_t>;

struct Offset {
  int x, y;
};

std::vector<Offset> disc(int radius) {
  std::vector<Offset> offsets;
  for (int y = -radius; y <= radius; ++y)
    for (int x = -radius; x <= radius; ++x)
      if (x * x + y * y <= radius * radius) offsets.push_back({x, y});
  return offsets;
}

template <class Work>
void each_row(int rows, const Run& run, Work&& work) {
  parallel_for(run, std::size_t((rows + kStripRows - 1) / kStripRows), [&](std::size_t i) {
    for (int y = int(i) * kStripRows; y < std::min(rows, int(i + 1) * kStripRows); ++y) work(y);
  });
}

// The smallest of the square around each pixel; NaN do not count.
FloatImage farthest_around(const FloatImage& surface, int radius, const Run& run) {
  const int width = surface.width, height = surface.height;
  constexpr float kNone = std::numeric_limits<float>::infinity();
  FloatImage rows(width, height, 1, kNone), result = rows;
  each_row(height, run, [&](int y) {
    const float* from = surface.row(y);
    float* to = rows.row(y);
    for (int d = -radius; d <= radius; ++d)
      for (int x = std::max(0, -d); x < width - std::max(0, d); ++x) to[x] = from[x + d] < to[x] ? from[x + d] : to[x];
  });
  each_row(height, run, [&](int y) {
    float* to = result.row(y);
    for (int v = std::max(0, y - radius); v <= std::min(height - 1, y + radius); ++v)
      for (int x = 0; x < width; ++x) to[x] = std::min(to[x], rows.at(x, v));
  });
  return result;
}

// Where the surface breaks off to something farther away within half a window: its continuation from the other side
// would be nearer by more than `reach` and two sigmas. A slope that goes on is none.
Mask fattened_pixels(const FloatImage& surface, const FloatImage& sigma, float reach, const Run& run) {
  const int width = surface.width, height = surface.height;
  const FloatImage farthest = farthest_around(surface, kHalfWindow, run);
  const auto breaks_off = [&](int x, int y) {
    const float twice = 2 * surface.at(x, y) - reach - 2 * sigma.at(x, y);
    const int reach_x = std::min({kHalfWindow, x, width - 1 - x}), reach_y = std::min({kHalfWindow, y, height - 1 - y});
    for (int j = 0; j <= reach_y; ++j)
      for (int i = -reach_x; i <= reach_x; ++i)
        if (surface.at(x + i, y + j) + surface.at(x - i, y - j) < twice) return true;
    return false;
  };
  Mask result(width, height);
  each_row(height, run, [&](int y) {
    for (int x = 0; x < width; ++x) result.at(x, y) = farthest.at(x, y) < surface.at(x, y) - reach && breaks_off(x, y);
  });
  return result;
}

}  // namespace

void empty_foreground_fattening(const GreyImage& image, float reach, const FloatImage& sigma, FloatImage& surface,
                                const Run& run) {
  const int width = surface.width, height = surface.height;
  const Mask fattened = fattened_pixels(surface, sigma, reach, run);
  std::array<float, 256> likeness;
  for (std::size_t i = 0; i < likeness.size(); ++i) likeness[i] = std::exp(-float(i) / kAlike);
  const std::vector<Offset> around = disc(kAround);
  const auto is_false = [&](int x, int y) {
    const float own = surface.at(x, y);
    const int grey = image.at(x, y);
    float in_front = 0, behind = 0;
    int front_pixels = 0, behind_pixels = 0;
    for (const Offset& offset : around) {
      const int u = x + offset.x, v = y + offset.y;
      if (u < 0 || v < 0 || u >= width || v >= height) continue;
      const float off = surface.at(u, v) - own;
      const float alike = likeness[std::size_t(std::abs(image.at(u, v) - grey))];
      if (off < -reach) {
        behind += alike;
        ++behind_pixels;
      } else if (off <= reach && !fattened.at(u, v)) {
        in_front += alike;
        ++front_pixels;
      }
    }
    return front_pixels >= kFewest && behind_pixels >= kFewest &&
           behind * float(front_pixels) > in_front * float(behind_pixels);
  };
  Mask emptied(width, height);
  each_row(height, run, [&](int y) {
    for (int x = 0; x < width; ++x) emptied.at(x, y) = fattened.at(x, y) && is_false(x, y);
  });
  for (std::size_t i = 0; i < surface.data.size(); ++i)
    if (emptied.data[i]) surface.data[i] = std::numeric_limits<float>::quiet_NaN();
}

}  // namespace collinea::dense
