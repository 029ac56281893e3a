// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "collinea/feature/edge_map.h"

// The linear filters of edge operators, and what white noise becomes in them.
namespace collinea {

/// Sampled at whole numbers -radius .. radius; sums to 1 (derivative 0), has the slope 1 on x (1) and 2 on x^2 (2).
[[nodiscard]] std::vector<double> gaussian_kernel(double sigma_px, int derivative);

/// Along rows by one kernel, then along columns by another; borders repeated.
[[nodiscard]] FloatImage separable(const FloatImage& image, const std::vector<double>& across,
                                   const std::vector<double>& down);

/// Two 3 x 3 masks that measure the slope along x and y: 1 for a ramp of 1 a pixel. Of a compass: the sum of its eight
/// responses as vectors. The measure is of the position `offset_px` beyond the middle of the pixel.
struct GradientMasks {
  EdgeMask x{}, y{};
  double offset_px = 0;
};
[[nodiscard]] GradientMasks gradient_masks(EdgeOperator of);

/// The largest response of a ramp of 1 a pixel, by which compass responses are divided; 1 of others.
[[nodiscard]] double compass_scale(EdgeOperator of);

/// Weights of 5 x 5 pixels, upper row first.
using Weights5 = std::array<double, 25>;

/// Covariance of white noise of unit variance after a Gaussian, as a product of two: factor at a distance of 0 .. 6.
class SmoothedNoise {
 public:
  explicit SmoothedNoise(double sigma_px);
  /// Of a weighted sum with the same sum `down` pixels below.
  [[nodiscard]] double covariance(const Weights5& weights, int down = 0) const;
  [[nodiscard]] double variance(const EdgeMask& mask) const;

 private:
  std::array<double, 7> at_{};
};

/// The ten coefficients of 1, x, y, x^2, xy, y^2, x^3, x^2 y, x y^2, y^3 that fit 5 x 5 pixels best, as weights of
/// these.
[[nodiscard]] const std::array<Weights5, 10>& facet_weights();
/// The six of 1, x, y, x^2, xy, y^2 for 3 x 3 pixels.
[[nodiscard]] const std::array<EdgeMask, 6>& paraboloid_weights();

}  // namespace collinea
