// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "collinea/base/words.h"
#include "collinea/raster/geotiff.h"
#include "collinea/surface/height_interpolation.h"

namespace collinea {

enum class GridMethod { kCollocation, kSplines, kTriangles, kPlanes };
inline constexpr Word<GridMethod> kGridMethodWords[] = {
    {GridMethod::kCollocation, "collocation", "least squares collocation, kriging with a fitted variogram"},
    {GridMethod::kSplines, "splines", "bicubic splines by least squares"},
    {GridMethod::kTriangles, "triangles", "linear within the triangles of Delaunay"},
    {GridMethod::kPlanes, "planes", "local planes by least squares"}};
[[nodiscard]] constexpr std::span<const Word<GridMethod>> words(GridMethod) { return kGridMethodWords; }

/// A raster of heights made from points.
struct GriddedPoints {
  GridMethod method = GridMethod::kCollocation;
  MapGrid grid;
  std::size_t points = 0, cells = 0;  ///< cells: that have a height
  std::optional<FittedCovariance> covariance;
  /// One in ten points left out and found from the others.
  std::size_t left_out = 0;
  double left_out_rms_m = 0;
  std::optional<double> left_out_variance_ratio;  ///< mean square of error over sigma, the points' own included
};

/// For a terminal.
[[nodiscard]] std::string gridded_text(const GriddedPoints& gridded);

}  // namespace collinea
