// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "collinea/raster/raster.h"

namespace collinea {

/// Grey value and slope of an image smoothed by the cubic B-spline (a blur of 0.58 px): the same between pixels as on
/// them, but for half a percent, and noise is smoothed nearly alike everywhere.
struct SplineSample {
  double grey = 0;
  Eigen::Vector2d slope{0, 0};             ///< [grey/px]
  int left = 0, top = 0;                   ///< of the 4 x 4 pixels it is made of
  std::array<double, 4> across{}, down{};  ///< their weights: across[i] * down[j]
};

/// Weights of the cubic B-spline and their derivatives for a position t in [0, 1] between the two middle ones of four.
inline void spline_weights(double t, std::array<double, 4>& value, std::array<double, 4>& slope) {
  const double s = 1 - t;
  value = {s * s * s / 6, (4 - 6 * t * t + 3 * t * t * t) / 6, (4 - 6 * s * s + 3 * s * s * s) / 6, t * t * t / 6};
  slope = {-s * s / 2, (-4 * t + 3 * t * t) / 2, (4 * s - 3 * s * s) / 2, t * t / 2};
}

/// Nothing less than two pixels inside the image.
inline std::optional<SplineSample> spline_sample(const GreyImage& image, const Eigen::Vector2d& at) {
  const double x = at.x() - 0.5, y = at.y() - 0.5;
  if (!(x >= 1 && y >= 1 && x < image.width - 2 && y < image.height - 2)) return std::nullopt;
  SplineSample out;
  const int column = static_cast<int>(x), row = static_cast<int>(y);
  out.left = column - 1;
  out.top = row - 1;
  std::array<double, 4> slope_across{}, slope_down{};
  spline_weights(x - column, out.across, slope_across);
  spline_weights(y - row, out.down, slope_down);
  for (int j = 0; j < 4; ++j) {
    const std::uint8_t* pixel = image.row(out.top + j) + out.left;
    const auto J = static_cast<std::size_t>(j);
    const double value =
        out.across[0] * pixel[0] + out.across[1] * pixel[1] + out.across[2] * pixel[2] + out.across[3] * pixel[3];
    const double along = slope_across[0] * pixel[0] + slope_across[1] * pixel[1] + slope_across[2] * pixel[2] +
                         slope_across[3] * pixel[3];
    out.grey += out.down[J] * value;
    out.slope.x() += out.down[J] * along;
    out.slope.y() += slope_down[J] * value;
  }
  return out;
}

}  // namespace collinea
