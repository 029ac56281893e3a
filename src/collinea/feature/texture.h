// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "collinea/raster/raster.h"

namespace collinea {

/// Measures of texture in a square window of `side` pixels (odd, at least 3) about every pixel; windows end at the
/// border of the image.
struct Texture {
  FloatImage mean, deviation;  ///< [grey]
  FloatImage entropy;          ///< -sum p log2 p of the grey values [bit]; at most log2 side^2 (6.34 of 9 x 9), not 8
  /// Of the co-occurrence of the grey values of right and lower neighbours (Haralick 1973), by 32 levels of 8.
  FloatImage contrast;     ///< mean square of their difference [levels^2]
  FloatImage homogeneity;  ///< mean of 1 / (1 + difference^2), 1 on uniform areas
};
[[nodiscard]] Texture texture_of(const GreyImage& image, int side);

/// Entropy alone.
[[nodiscard]] FloatImage entropy_of(const GreyImage& image, int side);

/// The same of one row.
[[nodiscard]] std::vector<float> entropy_of_row(const GreyImage& image, int side, int row);

/// 255 where the entropy is above a threshold: windows with enough texture to be matched; else 0.
[[nodiscard]] GreyImage entropy_mask(const FloatImage& entropy, double threshold);

}  // namespace collinea
