// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>

#include "collinea/match/area_matching.h"
#include "collinea/math/random.h"
#include "collinea/raster/raster.h"

// Images whose truth is exact, for tests of matching.
namespace collinea::testing {

/// A surface painted with waves of all directions, `shortest_px` to `longest_px` long.
class WaveTexture {
 public:
  explicit WaveTexture(std::uint64_t seed, double shortest_px = 6, double longest_px = 24, double amplitude_grey = 9) {
    Random random(seed);
    amplitude_grey_ = amplitude_grey;
    for (Wave& wave : waves_) {
      const double k = 2 * std::numbers::pi / random.uniform(shortest_px, longest_px);
      const double angle = random.uniform(0, 2 * std::numbers::pi);
      wave = {k * std::cos(angle), k * std::sin(angle), random.uniform(0, 2 * std::numbers::pi)};
    }
  }
  double operator()(const Eigen::Vector2d& at) const {
    double sum = 128;
    for (const Wave& wave : waves_) sum += amplitude_grey_ * std::sin(wave.x * at.x() + wave.y * at.y() + wave.phase);
    return sum;
  }

 private:
  struct Wave {
    double x = 0, y = 0, phase = 0;
  };
  std::array<Wave, 12> waves_;
  double amplitude_grey_ = 0;
};

/// The image of a painted plane: position (0.5, 0.5) is the centre of its first pixel.
inline GreyImage image_of(int width, int height, const std::function<double(const Eigen::Vector2d&)>& grey,
                          double noise_grey = 0, std::uint64_t seed = 1) {
  Random random(seed);
  GreyImage image(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      image.at(x, y) = static_cast<std::uint8_t>(
          std::clamp(std::round(grey({x + 0.5, y + 0.5}) + noise_grey * random.normal()), 0.0, 255.0));
  return image;
}

/// The peak that a measure finds in a window of 21 x 21 pixels of two noisy images, the right one shifted by up to half
/// a pixel, and what it is off by.
struct ShiftedPeak {
  GreyImage left, right;
  Eigen::Vector2i middle, best;
  SubpixelPeak peak;
  Eigen::Vector2d error_px;
};
/// Nothing without an extremum. Noise is that of `trial`, the shift the next one of `shifts`.
inline std::optional<ShiftedPeak> shifted_peak(const WaveTexture& texture, int size_px, double noise_grey,
                                               std::uint64_t trial, Random& shifts, Similarity method) {
  const double x = shifts.uniform(-0.5, 0.5), y = shifts.uniform(-0.5, 0.5);
  const Eigen::Vector2d shift(x, y);
  const Eigen::Vector2i middle(size_px / 2, size_px / 2);
  const auto shifted = [&](const Eigen::Vector2d& at) { return texture(at - shift); };
  ShiftedPeak out{image_of(size_px, size_px, texture, noise_grey, 2 * trial + 1),
                  image_of(size_px, size_px, shifted, noise_grey, 2 * trial + 2), middle};
  const auto surface = correlation_surface(out.left, middle, 10, out.right, middle, 3, method);
  const auto threshold = method == Similarity::kNcc ? std::optional(0.0) : std::nullopt;
  out.best = candidates(surface, 3, threshold).front().pixel;
  const auto peak = subpixel_peak(surface, out.best);
  if (!peak) return std::nullopt;
  out.peak = *peak;
  out.error_px = (out.best - middle).cast<double>() + peak->offset_px - shift;
  return out;
}

}  // namespace collinea::testing
