// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>

namespace collinea {

/// The largest whole number not above x; std::floor is a library call on baseline x86-64.
inline int floor_int(double x) {
  const int i = static_cast<int>(x);
  return i - (x < i);
}

/// 32 well mixed bits for a lattice point.
inline std::uint32_t lattice_bits(int x, int y, std::uint32_t seed) {
  std::uint32_t h =
      static_cast<std::uint32_t>(x) * 0x8da6b343u ^ static_cast<std::uint32_t>(y) * 0xd8163841u ^ seed * 0xcb1ab31fu;
  h = (h ^ (h >> 15)) * 0x2c1b3c6du;
  h = (h ^ (h >> 12)) * 0x297a2d39u;
  return h ^ (h >> 15);
}

/// Evenly spread in [-1, 1), one value for every lattice point.
inline float lattice_value(int x, int y, std::uint32_t seed) {
  return static_cast<float>(static_cast<std::int32_t>(lattice_bits(x, y, seed))) * 0x1p-31f;
}
/// Evenly spread in [0, 1).
inline float lattice_uniform(int x, int y, std::uint32_t seed) {
  return static_cast<float>(lattice_bits(x, y, seed) >> 8) * 0x1p-24f;
}

/// 0 below `low`, 1 above `high`, smooth between.
inline float smooth_step(float low, float high, float x) {
  const float t = std::clamp((x - low) / (high - low), 0.0f, 1.0f);
  return t * t * (3 - 2 * t);
}

/// Value noise in [-1, 1]: random lattice values, smoothly interpolated; standard deviation about 0.43.
inline float value_noise(double x, double y, std::uint32_t seed) {
  const int ix = floor_int(x), iy = floor_int(y);
  float u = static_cast<float>(x - ix), v = static_cast<float>(y - iy);
  u = u * u * (3 - 2 * u);
  v = v * v * (3 - 2 * v);
  const float low = lattice_value(ix, iy, seed), low_right = lattice_value(ix + 1, iy, seed);
  const float high = lattice_value(ix, iy + 1, seed), high_right = lattice_value(ix + 1, iy + 1, seed);
  const float bottom = low + u * (low_right - low), top = high + u * (high_right - high);
  return bottom + v * (top - bottom);
}

/// Octaves of value noise, each half the size of the one before, turned against it so that no lattice shows.
struct Fractal {
  double coarsest_m = 1;  ///< lattice spacing of the first octave
  int octaves = 1;
  float persistence = 1;  ///< amplitude of an octave over that of the one before
  std::uint32_t seed = 0;

  /// The sum at (x, y) [m], seen through a pixel of `footprint_m`: an octave fades out as its spacing goes from two
  /// footprints to one. The first octave has amplitude 1.
  [[nodiscard]] float operator()(double x, double y, double footprint_m) const {
    double u = x / coarsest_m, v = y / coarsest_m, spacing_m = coarsest_m;
    float sum = 0, amplitude = 1;
    for (int i = 0; i < octaves && spacing_m > footprint_m; ++i) {
      const float share = static_cast<float>(std::min(1.0, spacing_m / footprint_m - 1));
      sum += share * amplitude * value_noise(u, v, seed + static_cast<std::uint32_t>(i));
      const double turned = 1.6 * u - 1.2 * v;
      v = 1.2 * u + 1.6 * v;
      u = turned;
      spacing_m *= 0.5;
      amplitude *= persistence;
    }
    return sum;
  }
};

}  // namespace collinea
