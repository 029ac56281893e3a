// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <functional>

#include "collinea/math/random.h"
#include "collinea/raster/raster.h"

// Rendered shapes with known truth, for the tests of edges, curves and targets.
namespace collinea {

/// Share of white at a distance [px] inside of a straight border that a Gaussian of `blur_px` has blurred.
inline double blurred_step(double inside_px, double blur_px) {
  return 0.5 * std::erfc(-inside_px / (blur_px * std::sqrt(2.0)));
}

/// An image whose pixels are means over their area (5 x 5 samples) of dark + contrast * white(position), and noise.
inline FloatImage render_shape(int width, int height, const std::function<double(const Eigen::Vector2d&)>& white,
                               double noise_grey = 0, std::uint64_t seed = 1, double dark = 50, double contrast = 120) {
  FloatImage image(width, height);
  Random random(seed);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      double sum = 0;
      for (int s = 0; s < 25; ++s) sum += white({x + 0.1 + 0.2 * (s % 5), y + 0.1 + 0.2 * (s / 5)});
      image.at(x, y) = float(dark + contrast * sum / 25 + (noise_grey > 0 ? noise_grey * random.normal() : 0));
    }
  return image;
}

/// Adds white noise to a copy.
inline FloatImage with_noise(FloatImage image, double noise_grey, std::uint64_t seed) {
  Random random(seed);
  for (float& grey : image.data) grey += float(noise_grey * random.normal());
  return image;
}

/// White on the side of the line x cos + y sin = r towards which (cos, sin) points.
inline std::function<double(const Eigen::Vector2d&)> half_plane(double theta_rad, double r_px, double blur_px) {
  const Eigen::Vector2d normal(std::cos(theta_rad), std::sin(theta_rad));
  return [=](const Eigen::Vector2d& p) { return blurred_step(normal.dot(p) - r_px, blur_px); };
}

/// A white disc.
inline std::function<double(const Eigen::Vector2d&)> disc(const Eigen::Vector2d& centre, double radius_px,
                                                          double blur_px) {
  return [=](const Eigen::Vector2d& p) { return blurred_step(radius_px - (p - centre).norm(), blur_px); };
}

}  // namespace collinea
