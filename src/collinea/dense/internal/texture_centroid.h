// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/raster/raster.h"

namespace collinea::dense {

/// Where in its 7 x 7 window a pixel has its texture: the mean position of the squared grey differences, from the
/// middle [px]. What a window measures is the depth of that position.
struct TextureCentroid {
  FloatImage right, down;  ///< NaN without any texture

  /// At the border of an evenly textured surface the middle of what a window sees of it is half a window's reach away.
  [[nodiscard]] bool is_aside(int x, int y) const;
};

[[nodiscard]] TextureCentroid texture_centroid(const GreyImage& image);

/// Empties what windows measured beside the texture they catch: there the surface is not seen. It stays where the
/// surface goes on beyond, measured by windows without that texture: where inverse depths differ by no more than
/// `reach`.
void keep_textured(const TextureCentroid& centroid, float reach, FloatImage& surface);

}  // namespace collinea::dense
