// SPDX-License-Identifier: Apache-2.0
#include "collinea/image/pyramid.h"

#include <cmath>

#include "collinea/base/result.h"
#include "collinea/image/pyramid_kernels.h"

namespace collinea {
namespace {

// The overlaps of one output cell with the input cells along one axis, in 1/65536 of the output cell; they sum to
// 65536.
struct Overlap {
  int first = 0;
  std::vector<std::uint32_t> weights;
};

std::vector<Overlap> overlaps(int from, int to) {
  std::vector<Overlap> all(static_cast<std::size_t>(to));
  for (int i = 0; i < to; ++i) {
    // In units of 1 / to of an input cell everything is an integer.
    const std::int64_t low = std::int64_t(i) * from, high = low + from;
    Overlap& it = all[std::size_t(i)];
    it.first = int(low / to);
    std::uint32_t given = 0;
    for (std::int64_t cell = it.first; cell * to < high; ++cell) {
      // Rounded cumulatively, so that the sum is exact.
      const std::int64_t upto = std::min(high, (cell + 1) * to) - low;
      const auto total = std::uint32_t((upto * 65536 + from / 2) / from);
      it.weights.push_back(total - given);
      given = total;
    }
  }
  return all;
}

std::vector<float> gaussian(double sigma_px) {
  const int radius = std::max(1, int(std::ceil(4 * sigma_px)));
  std::vector<double> exact(std::size_t(2 * radius + 1));
  double sum = 0;
  for (int i = -radius; i <= radius; ++i)
    sum += exact[std::size_t(i + radius)] = std::exp(-0.5 * i * i / (sigma_px * sigma_px));
  std::vector<float> weights(exact.size());
  for (std::size_t i = 0; i < exact.size(); ++i) weights[i] = float(exact[i] / sum);
  return weights;
}

}  // namespace

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

Raster<std::uint8_t> resized(const Raster<std::uint8_t>& raster, int width, int height) {
  COLLINEA_CHECK(width >= 1 && height >= 1 && !raster.empty());
  const std::vector<Overlap> across = overlaps(raster.width, width), down = overlaps(raster.height, height);
  const std::size_t line = std::size_t(raster.width) * std::size_t(raster.channels);
  std::vector<std::uint32_t> sums(line);
  Raster<std::uint8_t> out(width, height, raster.channels);
  for (int y = 0; y < height; ++y) {
    std::fill(sums.begin(), sums.end(), 0u);
    const Overlap& rows = down[std::size_t(y)];
    for (std::size_t i = 0; i < rows.weights.size(); ++i) {
      const std::uint8_t* in = raster.row(rows.first + int(i));
      const std::uint32_t weight = rows.weights[i];
      for (std::size_t x = 0; x < line; ++x) sums[x] += weight * in[x];
    }
    for (int x = 0; x < width; ++x) {
      const Overlap& columns = across[std::size_t(x)];
      for (int c = 0; c < raster.channels; ++c) {
        std::uint64_t sum = std::uint64_t(1) << 31;  // one half, for rounding
        for (std::size_t i = 0; i < columns.weights.size(); ++i)
          sum += std::uint64_t(columns.weights[i]) *
                 sums[(std::size_t(columns.first) + i) * std::size_t(raster.channels) + std::size_t(c)];
        out.at(x, y, c) = std::uint8_t(sum >> 32);
      }
    }
  }
  return out;
}

FloatImage blurred(const FloatImage& raster, double sigma_px) {
  COLLINEA_CHECK(raster.channels == 1);
  if (sigma_px < 0.05 || raster.empty()) return raster;
  const std::vector<float> weights = gaussian(sigma_px);
  const int taps = int(weights.size()), radius = taps / 2;
  FloatImage out(raster.width, raster.height);
  std::vector<const float*> rows(weights.size());
  std::vector<float> padded(std::size_t(raster.width + 2 * radius));
  for (int y = 0; y < raster.height; ++y) {
    for (int i = 0; i < taps; ++i) rows[std::size_t(i)] = raster.row(std::clamp(y + i - radius, 0, raster.height - 1));
    float* middle = padded.data() + radius;
    weighted_sum(rows.data(), weights.data(), taps, middle, raster.width);
    std::fill(padded.begin(), padded.begin() + radius, middle[0]);
    std::fill(padded.end() - radius, padded.end(), middle[raster.width - 1]);
    for (int i = 0; i < taps; ++i) rows[std::size_t(i)] = padded.data() + i;
    weighted_sum(rows.data(), weights.data(), taps, out.row(y), raster.width);
  }
  return out;
}

}  // namespace collinea
