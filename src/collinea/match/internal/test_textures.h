// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>

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

}  // namespace collinea::testing
