// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "collinea/base/run.h"
#include "collinea/feature/interest.h"
#include "collinea/raster/raster.h"

namespace collinea {

/// Corners that any level may match (det / trace of Prewitt gradients), strongest first; of more than two million
/// those.
[[nodiscard]] std::vector<MapPixel> corners_of(const GreyImage& image, double least_threshold, const Run& run);

/// Those above a threshold, row by row.
[[nodiscard]] std::vector<Eigen::Vector2i> above(const std::vector<MapPixel>& corners, double threshold);

/// Pixels of a regular grid round which there is texture: entropy of 9 x 9 pixels above the least [bit]. Row by row.
[[nodiscard]] std::vector<Eigen::Vector2i> grid_pixels(const GreyImage& image, int step, double min_entropy,
                                                       const Run& run);

}  // namespace collinea
