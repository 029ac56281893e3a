// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>

#include "collinea/math/random.h"
#include "collinea/raster/raster.h"

namespace collinea::testing {

inline constexpr int kWidth = 300, kHeight = 120;

/// A sum of waves in all directions, none shorter than six pixels: its value between pixels is known.
struct Waves {
  std::array<double, 60> a, b, phase;

  explicit Waves(std::uint64_t seed) {
    Random random(seed);
    for (std::size_t i = 0; i < a.size(); ++i) {
      const double length = random.uniform(6, 24), direction = random.uniform(0, 6.283);
      a[i] = 6.283 / length * std::cos(direction);
      b[i] = 6.283 / length * std::sin(direction);
      phase[i] = random.uniform(0, 6.283);
    }
  }
  [[nodiscard]] double operator()(double x, double y) const {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += std::cos(a[i] * x + b[i] * y + phase[i]);
    return 128 + 8 * sum;
  }
};

/// Standard deviation 1; grain is white noise under weights 1 2 1 along rows and columns.
inline FloatImage noise_of(Random random, bool is_grain) {
  FloatImage white(kWidth, kHeight, 1);
  for (float& value : white.data) value = float(random.normal());
  if (!is_grain) return white;
  FloatImage grain(kWidth, kHeight, 1);
  for (int y = 1; y + 1 < kHeight; ++y)
    for (int x = 1; x + 1 < kWidth; ++x)
      for (int k = 0; k < 9; ++k)
        grain.at(x, y) +=
            float((2 - std::abs(k % 3 - 1)) * (2 - std::abs(k / 3 - 1))) / 6 * white.at(x + k % 3 - 1, y + k / 3 - 1);
  return grain;
}

/// A plane of disparities, d = 20 + gradient . (x - 150, y - 60): the left column of a right one in closed form.
struct PlanePair {
  Eigen::Vector2d gradient;
  GreyImage left{kWidth, kHeight, 1}, right{kWidth, kHeight, 1};

  PlanePair(const Eigen::Vector2d& g, double noise_grey, std::uint64_t seed, bool is_grain = false) : gradient(g) {
    const Waves waves(seed);
    const FloatImage noise[] = {noise_of(Random(seed, 1), is_grain), noise_of(Random(seed, 2), is_grain)};
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        const double v = y + 0.5, c = x + 0.5;
        int image = 0;
        const auto grey = [&](double value) {
          value += noise_grey * double(noise[image++].at(x, y));
          return std::uint8_t(std::clamp(std::lround(value), 1L, 255L));
        };
        left.at(x, y) = grey(waves(c, v));
        // c = u - 20 - gx (u - 150) - gy (v - 60)
        right.at(x, y) = grey(0.9 * waves((c + 20 - g.x() * 150 + g.y() * (v - 60)) / (1 - g.x()), v) + 9);
      }
  }
  [[nodiscard]] double disparity(const Eigen::Vector2i& pixel) const {
    return 20 + gradient.dot(pixel.cast<double>() + Eigen::Vector2d(0.5 - 150, 0.5 - 60));
  }
};

}  // namespace collinea::testing
