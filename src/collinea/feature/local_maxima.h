// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "collinea/raster/raster.h"

namespace collinea {

/// A pixel of a map by its column and row, counted from 0.
struct MapPixel {
  int column = 0, row = 0;
  float value = 0;

  bool operator==(const MapPixel&) const = default;
};

/// The local maxima of a map (non-maximum suppression): pixels above the threshold with no larger value within
/// `radius_px` columns and rows, largest first. Neighbours of the same value (a plateau) count as one maximum, at the
/// one of them that is nearest to their mean, and as none where a larger value touches any of them. Of equal maxima
/// within the radius of one another the upper, then the left one stays. NaN is never a maximum.
[[nodiscard]] std::vector<MapPixel> local_maxima(const FloatImage& map, int radius_px, float threshold);

}  // namespace collinea
