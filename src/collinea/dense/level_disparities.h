// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "collinea/base/run.h"
#include "collinea/dense/internal/disparity_map.h"
#include "collinea/dense/level_matching.h"

namespace collinea {

/// The surface of a rectified pair by levels.
struct LevelDisparities {
  LevelSurface surface;  ///< of its points those in the range
  DisparityMap map;      ///< the same by pixel; NaN between them
};

/// match_by_levels() of a rectified pair as it is, without an orientation that guides: the first model are interest
/// points (Noble's measure, evenly spread) looked for in the whole range with the template and the least correlation of
/// the options, there and back, without spikes. Rows are exact: one on either side is searched, too. Errors: as
/// match_pair() and match_by_levels(); fewer than three such points.
[[nodiscard]] Result<LevelDisparities> match_rectified_by_levels(const GreyImage& left, const GreyImage& right,
                                                                 const DisparityRange& range,
                                                                 const LevelOptions& options, const Run& run);

/// Fills holes by the planes through the corners of the triangles between points; stays as it is outside of them, and
/// when points make no triangle.
void fill_by_triangles(std::span<const LevelPoint> points, FloatImage& disparity, const Run& run);

}  // namespace collinea
