// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "collinea/dense/internal/disparity_map.h"
#include "collinea/dense/internal/test_scene.h"
#include "collinea/math/random.h"

namespace collinea::test {

/// A rectified pair of a plane with disparity `at_left + slope * column`, and, when it is asked for, a square before it
/// with a disparity of its own.
struct TestPair {
  int width = 200, height = 120;
  double at_left = 12.3, slope = 0;
  double square = 0;    // its disparity; 0: none
  double brighter = 0;  // the square than the plane, grey values
  double noise = 0;

  [[nodiscard]] double grey(double x, double y, bool on_square) const {
    return 125 + (on_square ? brighter : 0) +
           (on_square ? 9 : 10) * Scene::wave(0.06 * x + (on_square ? 40 : 0), 0.06 * y);
  }
  [[nodiscard]] bool on_square(double x, int y) const { return square > 0 && x >= 80 && x < 130 && y >= 35 && y < 85; }
  [[nodiscard]] double truth(int x, int y) const { return on_square(x, y) ? square : at_left + slope * x; }
  // whether the right image shows what the left one shows there
  [[nodiscard]] bool seen_twice(int x, int y) const {
    const double other = x - truth(x, y);
    return other >= 0 && (on_square(x, y) || !on_square(other + square, y));
  }

  [[nodiscard]] GreyImage image_of(bool is_left) const {
    GreyImage result(width, height);
    Random random(3, is_left);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        const bool before = on_square(is_left ? x : x + square, y);
        const double at = is_left ? x : before ? x + square : (x + at_left) / (1 - slope);
        result.at(x, y) = std::uint8_t(std::clamp(grey(at, y, before) + noise * random.normal() + 0.5, 1.0, 255.0));
      }
    return result;
  }
};

struct DisparityErrors {
  int possible = 0, measured = 0, bad = 0;
  double rms = 0, in_sigmas = 0;
};

/// Of the pixels that both images show, `border` pixels off the edge of the image.
inline DisparityErrors errors_of(const TestPair& pair, const DisparityMap& map, int border = 6) {
  DisparityErrors e;
  double squares = 0, relative = 0;
  for (int y = border; y < pair.height - border; ++y)
    for (int x = border; x < pair.width - border; ++x) {
      if (!pair.seen_twice(x, y)) continue;
      ++e.possible;
      if (std::isnan(map.disparity.at(x, y))) continue;
      ++e.measured;
      const double off = map.disparity.at(x, y) - pair.truth(x, y);
      if (std::abs(off) > 1) {
        ++e.bad;
        continue;
      }
      squares += off * off;
      relative += std::pow(off / map.sigma.at(x, y), 2);
    }
  e.rms = std::sqrt(squares / (e.measured - e.bad));
  e.in_sigmas = std::sqrt(relative / (e.measured - e.bad));
  return e;
}

}  // namespace collinea::test
