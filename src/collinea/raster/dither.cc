// SPDX-License-Identifier: Apache-2.0
#include "collinea/raster/dither.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "collinea/raster/grey_table.h"

namespace collinea {
namespace {

// The grey values of the result, and which of them is nearest to each value of 0 .. 255.
struct Levels {
  std::vector<int> grey;
  explicit Levels(int count) {
    for (int i = 0; i < count; ++i) grey.push_back(static_cast<int>(std::lround(255.0 * i / (count - 1))));
  }
  // Of a value with sixteen steps to a grey value.
  [[nodiscard]] int nearest(int sixteenths) const {
    const auto last = static_cast<int>(grey.size()) - 1;
    const int i = std::clamp((sixteenths * last + 255 * 8) / (255 * 16), 0, last);
    return grey[std::size_t(i)];
  }
};

// In which order the pixels of a cell become bright.
std::vector<int> ranks_of(int cell) {
  std::vector<int> rank(std::size_t(cell * cell));
  if ((cell & (cell - 1)) == 0) {
    for (int y = 0; y < cell; ++y)
      for (int x = 0; x < cell; ++x) {
        int r = 0;
        for (int bit = 1; bit < cell; bit *= 2) {
          const int u = (x / bit) % 2, v = (y / bit) % 2;
          r = 4 * r + 2 * (u ^ v) + v;  // the finest bit counts most
        }
        rank[std::size_t(y * cell + x)] = r;
      }
    return rank;
  }
  // A step of about 0.382 of all (golden section) that has no factor in common with them visits every pixel once.
  const int all = cell * cell;
  int step = static_cast<int>(std::lround(0.382 * all));
  const auto common = [&](int n) {
    int a = n, b = all;
    while (b != 0) std::swap(a %= b, b);
    return a;
  };
  while (common(step) != 1) ++step;
  for (int i = 0, at = 0; i < all; ++i, at = (at + step) % all) rank[std::size_t(at)] = i;
  return rank;
}

}  // namespace

Raster<std::uint8_t> dithered_by_diffusion(const Raster<std::uint8_t>& image, int levels, const GreyImage* known) {
  const Levels values(levels);
  Raster<std::uint8_t> out(image.width, image.height, image.channels);
  const auto channels = std::size_t(image.channels);
  const std::size_t length = (std::size_t(image.width) + 2) * channels;  // a pixel beside either end
  std::vector<int> here(length), below(length);                          // errors, in sixteenths of a grey value
  for (int y = 0; y < image.height; ++y) {
    std::ranges::fill(below, 0);
    const std::uint8_t* in = image.row(y);
    std::uint8_t* to = out.row(y);
    for (std::size_t i = 0; i < std::size_t(image.width) * channels; ++i) {
      if (known && known->row(y)[i / channels] == 0) continue;
      const int wanted = 16 * in[i] + here[i + channels];
      const int grey = values.nearest(std::clamp(wanted, 0, 255 * 16));
      to[i] = static_cast<std::uint8_t>(grey);
      const int error = wanted - 16 * grey;
      const int right = error * 7 / 16, left_below = error * 3 / 16, straight_below = error * 5 / 16;
      here[i + 2 * channels] += right;
      below[i] += left_below;
      below[i + channels] += straight_below;
      below[i + 2 * channels] += error - right - left_below - straight_below;
    }
    std::swap(here, below);
  }
  return out;
}

Raster<std::uint8_t> dithered_by_cells(const Raster<std::uint8_t>& image, int levels, int cell) {
  const Levels values(levels);
  const std::vector<int> ranks = ranks_of(cell);
  const int shades = shades_of(levels, cell) - 1, all = cell * cell;
  // A table for each pixel of a cell.
  std::vector<GreyTable> tables(ranks.size());
  for (std::size_t p = 0; p < ranks.size(); ++p)
    for (int g = 0; g < kGreyValues; ++g) {
      const int shade = (2 * g * shades + 255) / (2 * 255);
      tables[p][std::size_t(g)] =
          static_cast<std::uint8_t>(values.grey[std::size_t(shade / all + (ranks[p] < shade % all ? 1 : 0))]);
    }
  Raster<std::uint8_t> out(image.width, image.height, image.channels);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const GreyTable& table = tables[std::size_t((y % cell) * cell + x % cell)];
      for (int c = 0; c < image.channels; ++c) out.at(x, y, c) = table[image.at(x, y, c)];
    }
  return out;
}

}  // namespace collinea
