// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>

#include "collinea/base/options.h"
#include "collinea/base/run.h"
#include "collinea/report/gridded_text.h"

namespace collinea {

/// How a raster of heights is made from points.
struct GridPointsOptions {
  GridMethod method = GridMethod::kCollocation;
  std::optional<double> cell_m;
  std::optional<CovarianceModel> covariance;
  std::optional<double> spacing_m;
  std::optional<double> longest_m;
  int nearest = 24;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = GridPointsOptions;
    visit(Field{"method", &O::method, "", "how heights between points are found"});
    visit(Field{"cell_m", &O::cell_m, "m", "of the raster; nothing: half the mean distance of the points", 1e-6, 1e6});
    visit(Field{"covariance", &O::covariance, "",
                "of collocation: how alike heights at a distance are; nothing: what fits the points best"});
    visit(Field{"spacing_m", &O::spacing_m, "m",
                "of splines: side of their squares; nothing: twice the mean distance of the points", 1e-6, 1e6});
    visit(Field{"longest_m", &O::longest_m, "m",
                "of triangles: nothing in those with a longer side; nothing: all are filled", 1e-6, 1e9});
    visit(Field{"nearest", &O::nearest, "", "points that make a height, of collocation and planes", 4, 200});
  }
};

/// Writes heights (GeoTIFF) from a text table with columns X, Y, Z [m] and sigma_Z, and their standard deviations to
/// NAME_sigma.tif beside it. Errors: files, options, too few points.
[[nodiscard]] Result<GriddedPoints> grid_points(const std::filesystem::path& points, const std::filesystem::path& out,
                                                const GridPointsOptions& options, const Run& run);

}  // namespace collinea
