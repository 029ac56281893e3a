// SPDX-License-Identifier: Apache-2.0
#include "collinea/synthetic/internal/country.h"

#include <array>
#include <cmath>

#include "collinea/synthetic/internal/noise.h"

namespace collinea {

double smooth_noise(double x, double y, std::uint32_t seed) {
  const auto ease = [](double t) { return t * t * t * (t * (6 * t - 15) + 10); };
  const int ix = floor_int(x), iy = floor_int(y);
  const double u = ease(x - ix), v = ease(y - iy);
  const auto at = [&](int i, int j) { return double(lattice_value(ix + i, iy + j, seed)); };
  return (1 - v) * ((1 - u) * at(0, 0) + u * at(1, 0)) + v * ((1 - u) * at(0, 1) + u * at(1, 1));
}

double hill_height(double x, double y, double relief_m, std::uint32_t seed) {
  struct Octave {
    double spacing_m, share;
  };
  constexpr std::array<Octave, 5> kOctaves = {{{130, 0.62}, {55, 0.22}, {22, 0.07}, {8, 0.015}, {1.7, 0.006}}};
  double sum = 0, u = x, v = y;
  for (std::size_t i = 0; i < kOctaves.size(); ++i) {
    sum +=
        kOctaves[i].share * smooth_noise(u / kOctaves[i].spacing_m, v / kOctaves[i].spacing_m, seed + std::uint32_t(i));
    const double turned = 0.8 * u - 0.6 * v;
    v = 0.6 * u + 0.8 * v;
    u = turned;
  }
  return relief_m * sum;
}

Heightfield terrain_of(const CountryOptions& o, const std::function<double(double x, double y)>& height) {
  const int width = int(std::ceil((o.high.x() - o.low.x()) / o.cell_m)) + 2;
  const int rows = int(std::ceil((o.high.y() - o.low.y()) / o.cell_m)) + 2;
  const double datum = height(0, 0);
  std::vector<float> heights;
  heights.reserve(std::size_t(width) * std::size_t(rows));
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < width; ++column)
      heights.push_back(float(height(o.low.x() + column * o.cell_m, o.low.y() + row * o.cell_m) - datum));
  return {o.low.x(), o.low.y(), o.cell_m, width, rows, std::move(heights)};
}

}  // namespace collinea
