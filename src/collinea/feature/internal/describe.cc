// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/internal/describe.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace collinea {
namespace {

constexpr double kDirectionWindow = 1.5;  // its standard deviation, in blurs of the feature
constexpr double kCell = 3;               // width of a descriptor's cell, in blurs of the feature
// The scale of a feature is not exact, and slanted surfaces have none: patches of several sizes stand for all of them.
constexpr double kPatchSizes[] = {1 / 1.5, 1, 1.5};
// A cell is at least two blurs wide: the gradients of a quarter of it differ little from row to row.
constexpr double kRowsOfCell = 4;
constexpr float kLeastPeak = 0.8f;     // of the highest
constexpr float kLargestValue = 0.2f;  // of the norm
constexpr float kNorm = 512;
constexpr float kLargestByte = 127;  // seven bits are multiplied faster (match/descriptors_kernels.cc)

using Histogram = std::array<float, kDirectionBins>;

float around(const Histogram& histogram, int bin) {
  return histogram[static_cast<std::size_t>((bin + kDirectionBins) % kDirectionBins)];
}

Histogram smoothed(const Histogram& in) {
  Histogram out;
  for (int b = 0; b < kDirectionBins; ++b)
    out[static_cast<std::size_t>(b)] =
        (around(in, b - 2) + 4 * around(in, b - 1) + 6 * around(in, b) + 4 * around(in, b + 1) + around(in, b + 2)) /
        16;
  return out;
}

}  // namespace

MainDirections main_directions(const BlurredImage& image, float x, float y, double blur_px) {
  Histogram raw;
  direction_histogram(image, x, y, static_cast<float>(kDirectionWindow * blur_px), raw.data());
  const Histogram histogram = smoothed(raw);
  const float highest = *std::ranges::max_element(histogram);

  struct Peak {
    float height, angle_rad;
  };
  std::array<Peak, kDirectionBins / 2> peaks;
  std::size_t count = 0;
  for (int b = 0; b < kDirectionBins && highest > 0; ++b) {
    const float before = around(histogram, b - 1), at = around(histogram, b), after = around(histogram, b + 1);
    if (at < kLeastPeak * highest || at <= before || at < after) continue;
    const float bin = b + 0.5f * (before - after) / (before - 2 * at + after);
    const float turns = bin / kDirectionBins;
    peaks[count++] = {at, 2 * std::numbers::pi_v<float> * (turns - std::floor(turns))};
  }
  std::stable_sort(peaks.begin(), peaks.begin() + static_cast<std::ptrdiff_t>(count),
                   [](const Peak& a, const Peak& b) { return a.height > b.height; });
  MainDirections directions;
  directions.count = std::min(count, MainDirections::kMost);
  for (std::size_t i = 0; i < directions.count; ++i) directions.angle_rad[i] = peaks[i].angle_rad;
  return directions;
}

Descriptor root_descriptor(std::array<float, 128> histogram) {
  float squares = 0;
  for (const float value : histogram) squares += value * value;
  const float largest = kLargestValue * std::sqrt(squares);
  float sum = 0;
  for (float& value : histogram) {
    value = std::min(value, largest);
    sum += value;
  }
  Descriptor descriptor{};
  if (!(sum > 0)) return descriptor;
  for (std::size_t k = 0; k < histogram.size(); ++k)
    descriptor[k] = static_cast<std::uint8_t>(std::min(kLargestByte, kNorm * std::sqrt(histogram[k] / sum) + 0.5f));
  return descriptor;
}

Descriptor describe_patch(const BlurredImage& image, float x, float y, double blur_px, float angle_rad) {
  std::array<float, 128> pooled{};
  for (const double size : kPatchSizes) {
    std::array<float, 128> histogram;
    const double cell_px = size * kCell * blur_px;
    gradient_patch(image, x, y, angle_rad, static_cast<float>(cell_px),
                   std::max(1, static_cast<int>(cell_px / kRowsOfCell)), histogram.data());
    float squares = 0;
    for (const float value : histogram) squares += value * value;
    const float scale = squares > 0 ? 1 / std::sqrt(squares) : 0;
    for (std::size_t k = 0; k < pooled.size(); ++k) pooled[k] += scale * histogram[k];
  }
  return root_descriptor(pooled);
}

}  // namespace collinea
