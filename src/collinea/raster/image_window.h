// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "collinea/base/result.h"
#include "collinea/raster/jpeg_reader.h"
#include "collinea/raster/raster.h"

namespace collinea {

/// Grey values of a window of an image file (JPEG, PNG, TIFF), nothing else of it in memory; of colour the luma. Those
/// of 8 bits are as they are; of deeper images they are scaled so that the window's own go from 0 to 255. The window
/// lies inside the image as it was imported; a JPEG of another size is taken as it is. Errors: missing, no image,
/// damaged, a window that is not inside it.
[[nodiscard]] Result<FloatImage> read_grey_window(const std::filesystem::path& path, int width_px, int height_px,
                                                  const PixelWindow& window);

}  // namespace collinea
