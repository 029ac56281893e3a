// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/raster/raster.h"

namespace collinea::dense {

inline constexpr int kTextureReach = 3;  ///< half the window of the mean
/// Bits after the point of the number that sums are multiplied by, instead of a division.
inline constexpr int kTexturePartBits = 20;

/// How much texture there is around each pixel: the sum of the differences of grey values to the pixels to the right
/// and below (at most 255), its mean over 7 x 7 pixels, cut at the border and rounded down.
[[nodiscard]] GreyImage texture_around(const GreyImage& image);

}  // namespace collinea::dense
