// SPDX-License-Identifier: Apache-2.0
#include "collinea/raster/rescale.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "collinea/base/parallel.h"
#include "collinea/base/result.h"

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

// Of an even number the mean of both in the middle, rounded. The values get another order.
std::uint8_t median_of(std::vector<std::uint8_t>& values) {
  const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
  std::ranges::nth_element(values, middle);
  int twice = 2 * *middle;
  if (values.size() % 2 == 0) twice = *middle + *std::max_element(values.begin(), middle);
  return static_cast<std::uint8_t>((twice + 1) / 2);
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
      *out++ = median_of(values);
    }
  }
}

// Of what is known, by its weight.
void weighted_row_of_known(const Raster<std::uint8_t>& image, const GreyImage& known, const Taps& across,
                           const std::vector<Taps>& along, std::uint8_t* out, std::uint8_t* out_known) {
  const auto channels = std::size_t(image.channels);
  for (std::size_t x = 0; x < along.size(); ++x) {
    float weight = 0;
    std::array<float, 4> values{};
    for (std::size_t j = 0; j < across.weights.size(); ++j)
      for (std::size_t k = 0; k < along[x].weights.size(); ++k) {
        const int column = along[x].first + int(k), row = across.first + int(j);
        if (known.at(column, row) == 0) continue;
        const float one = across.weights[j] * along[x].weights[k];
        weight += one;
        for (std::size_t c = 0; c < channels; ++c) values[c] += one * float(image.at(column, row, int(c)));
      }
    if (!(weight >= 0.5f)) continue;
    out_known[x] = 255;
    for (std::size_t c = 0; c < channels; ++c) out[x * channels + c] = rounded(values[c] / weight);
  }
}

void median_row_of_known(const Raster<std::uint8_t>& image, const GreyImage& known, int y, double factor,
                         std::uint8_t* out, std::uint8_t* out_known, int width) {
  const auto [top, bottom] = covered(y, image.height, factor);
  std::vector<std::uint8_t> values;
  for (int x = 0; x < width; ++x) {
    const auto [left, right] = covered(x, image.width, factor);
    for (int c = 0; c < image.channels; ++c) {
      values.clear();
      for (int v = top; v < bottom; ++v)
        for (int u = left; u < right; ++u)
          if (known.at(u, v) != 0) values.push_back(image.at(u, v, c));
      if (2 * values.size() < std::size_t(bottom - top) * std::size_t(right - left)) continue;
      out_known[x] = 255;
      out[x * image.channels + c] = median_of(values);
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

ReducedPart reduced(const Raster<std::uint8_t>& image, const GreyImage& known, double factor, Reduction reduction,
                    const Run& run) {
  if (image.empty() || factor <= 1) return {image, known};
  COLLINEA_CHECK(image.channels <= 4);
  const int width = static_cast<int>(std::ceil(image.width / factor - 1e-9));
  const int height = static_cast<int>(std::ceil(image.height / factor - 1e-9));
  ReducedPart out{Raster<std::uint8_t>(width, height, image.channels), GreyImage(width, height)};
  const bool is_median = reduction == Reduction::kMedian;
  const auto along = is_median ? std::vector<Taps>() : all_taps(width, image.width, factor, reduction);
  parallel_for(run, std::size_t(height), [&](std::size_t row) {
    const int y = int(row);
    if (is_median)
      median_row_of_known(image, known, y, factor, out.image.row(y), out.known.row(y), width);
    else
      weighted_row_of_known(image, known, taps_of(y, image.height, factor, reduction), along, out.image.row(y),
                            out.known.row(y));
  });
  return out;
}

}  // namespace collinea
