// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "collinea/base/run.h"
#include "collinea/raster/geotiff.h"

namespace collinea {

/// An image on the map, read by windows inside the raster; 1, 3 or 4 channels, the fourth is alpha.
struct ImageField {
  MapGrid grid;
  std::function<Result<Raster<std::uint8_t>>(int column, int row, int width, int height)> read;
};

struct OrthoErrors {
  double cell_m = 0;                    ///< of the assessed orthophoto; its pixel
  std::size_t windows = 0;              ///< textured windows looked for
  double share_failed = 0;              ///< of these, not found again within the search range, or hardly alike
  double rms_x_px = 0, rms_y_px = 0;    ///< shift of those found
  double mean_x_px = 0, mean_y_px = 0;  ///< to the east, to the south
  double median_px = 0;                 ///< of the length of the shift
  double share_over_1_px = 0;
};

/// The shift of an orthophoto against the true one: windows of 31 x 31 pixels every 48 pixels with texture in all
/// directions, searched up to 6 pixels away by normalised cross-correlation with a parabola through the peak. Windows
/// that touch transparent pixels are left out. Errors: reading; no textured window in common; cancelled.
[[nodiscard]] Result<OrthoErrors> ortho_errors(const ImageField& product, const ImageField& truth, const Run& run);

}  // namespace collinea
