// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <functional>
#include <span>
#include <vector>

#include "collinea/base/run.h"
#include "collinea/dense/level_point.h"
#include "collinea/raster/raster.h"

namespace collinea {

struct GrowthOptions {
  int step_px = 4;  ///< of the grid
  int half = 6;     ///< windows of 2 half + 1 pixels
  double min_ncc = 0.6, return_px = 1.5;
  std::function<int(const Eigen::Vector2i& pixel)> rows;  ///< searched on either side
};

/// Lets matches of a regular grid of pixels spread (region growing; Otto and Chau 1989): a pixel without a match looks
/// for one within two pixels of the planes of its eight neighbours that have one, with windows of their slope, and the
/// best that is good enough is measured by least squares; new matches are neighbours in the next pass, until there are
/// none. `points` are matches of some of `pixels`; what it found is added to them. Same bits for any number of threads.
[[nodiscard]] std::vector<LevelPoint> grown(const GreyImage& left, const GreyImage& right,
                                            std::span<const Eigen::Vector2i> pixels, std::vector<LevelPoint> points,
                                            const GrowthOptions& options, const Run& run);

/// Matches of pixels, in their order, near the planes of the six nearest points of a model, at most 100 px away: as
/// grown() by neighbours.
[[nodiscard]] std::vector<LevelPoint> matched_near(const GreyImage& left, const GreyImage& right,
                                                   std::span<const Eigen::Vector2i> pixels,
                                                   std::span<const LevelPoint> model, const GrowthOptions& options,
                                                   const Run& run);

}  // namespace collinea
