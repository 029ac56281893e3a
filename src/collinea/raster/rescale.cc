// SPDX-License-Identifier: Apache-2.0
#include "collinea/raster/rescale.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "collinea/base/parallel.h"

namespace collinea {
namespace {

constexpr int kLobes = 3;
constexpr int kRowsAtOnce = 16;

// The pixels that one of the result is made of, with their weights.
struct Taps {
  int first = 0;
  std::vector<float> weights;
};

double sinc(double t) { return t == 0 ? 1 : std::sin(std::numbers::pi * t) / (std::numbers::pi * t); }

Taps taps_of(int at, int size, double factor, Reduction reduction) {
  const double middle = (at + 0.5) * factor, reach = reduction == Reduction::kSinc ? kLobes * factor : factor / 2;
  Taps taps;
  taps.first = std::clamp(static_cast<int>(std::floor(middle - reach)), 0, size - 1);
  const int end = std::clamp(static_cast<int>(std::ceil(middle + reach)), taps.first + 1, size);
  double sum = 0;
  std::vector<double> weights;
  for (int i = taps.first; i < end; ++i) {
    const double d = (i + 0.5 - middle) / factor;
    const double weight = reduction == Reduction::kSinc
                              ? (std::abs(d) < kLobes ? sinc(d) * sinc(d / kLobes) : 0)
                              : std::max(0.0, std::min(i + 1.0, middle + reach) - std::max(double(i), middle - reach));
    weights.push_back(weight);
    sum += weight;
  }
  for (const double weight : weights) taps.weights.push_back(static_cast<float>(weight / sum));
  return taps;
}

std::vector<Taps> all_taps(int count, int size, double factor, Reduction reduction) {
  std::vector<Taps> out;
  for (int i = 0; i < count; ++i) out.push_back(taps_of(i, size, factor, reduction));
  return out;
}

std::uint8_t rounded(float value) { return static_cast<std::uint8_t>(std::clamp(value + 0.5f, 0.0f, 255.0f)); }

// Across the rows first: that adds up whole rows, and leaves few of them for the sums along.
void weighted_row(const Raster<std::uint8_t>& image, const Taps& across, const std::vector<Taps>& along,
                  std::vector<float>& sum, std::uint8_t* out) {
  std::ranges::fill(sum, 0.0f);
  for (std::size_t k = 0; k < across.weights.size(); ++k) {
    const std::uint8_t* row = image.row(across.first + int(k));
    const float weight = across.weights[k];
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += weight * float(row[i]);
  }
  const auto channels = std::size_t(image.channels);
  for (const Taps& taps : along)
    for (std::size_t c = 0; c < channels; ++c) {
      float value = 0;
      const float* from = sum.data() + std::size_t(taps.first) * channels + c;
      for (std::size_t k = 0; k < taps.weights.size(); ++k) value += taps.weights[k] * from[k * channels];
      *out++ = rounded(value);
    }
}

// The pixels whose middles lie in the new one; the nearest where none does.
std::pair<int, int> covered(int at, int size, double factor) {
  const int first = std::clamp(static_cast<int>(std::ceil(at * factor - 0.5)), 0, size - 1);
  return {first, std::clamp(static_cast<int>(std::ceil((at + 1) * factor - 0.5)), first + 1, size)};
}

void median_row(const Raster<std::uint8_t>& image, int y, double factor, int width, std::uint8_t* out) {
  const auto [top, bottom] = covered(y, image.height, factor);
  std::vector<std::uint8_t> values;
  for (int x = 0; x < width; ++x) {
    const auto [left, right] = covered(x, image.width, factor);
    for (int c = 0; c < image.channels; ++c) {
      values.clear();
      for (int v = top; v < bottom; ++v)
        for (int u = left; u < right; ++u) values.push_back(image.at(u, v, c));
      const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
      std::ranges::nth_element(values, middle);
      int twice = 2 * *middle;
      if (values.size() % 2 == 0) twice = *middle + *std::max_element(values.begin(), middle);
      *out++ = static_cast<std::uint8_t>((twice + 1) / 2);
    }
  }
}

}  // namespace

Raster<std::uint8_t> reduced(const Raster<std::uint8_t>& image, double factor, Reduction reduction, const Run& run) {
  if (image.empty() || factor <= 1) return image;
  const int width = static_cast<int>(std::ceil(image.width / factor - 1e-9));
  const int height = static_cast<int>(std::ceil(image.height / factor - 1e-9));
  Raster<std::uint8_t> out(width, height, image.channels);
  const bool is_median = reduction == Reduction::kMedian;
  const auto along = is_median ? std::vector<Taps>() : all_taps(width, image.width, factor, reduction);
  const auto across = is_median ? std::vector<Taps>() : all_taps(height, image.height, factor, reduction);
  parallel_for(run, std::size_t((height + kRowsAtOnce - 1) / kRowsAtOnce), [&](std::size_t strip) {
    const int first = int(strip) * kRowsAtOnce;
    std::vector<float> sum(std::size_t(image.width) * std::size_t(image.channels));
    for (int y = first; y < std::min(height, first + kRowsAtOnce); ++y)
      if (is_median)
        median_row(image, y, factor, width, out.row(y));
      else
        weighted_row(image, across[std::size_t(y)], along, sum, out.row(y));
  });
  return out;
}

}  // namespace collinea
