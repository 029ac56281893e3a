// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "collinea/raster/raster.h"

namespace collinea {

constexpr double kSteepestSmooth = 0.3;  ///< rise per run of smooth ground

/// 1 where the surface is steeper than `steepest` (rise per run), and at all cells within `margin` of such, both ways.
[[nodiscard]] Raster<std::uint8_t> rough_cells(const FloatImage& heights_m, double cell_m, int margin, double steepest);

}  // namespace collinea
