// SPDX-License-Identifier: Apache-2.0
#include "collinea/surface/surface_contours.h"

#include <cmath>
#include <utility>

#include "collinea/base/file.h"
#include "collinea/surface/height_field.h"
#include "collinea/surface/internal/terrain_contours.h"

namespace collinea {

Result<DrawnContours> draw_surface_contours(const std::filesystem::path& heights, double sigma_m,
                                            const std::filesystem::path& geopackage, const std::filesystem::path& dxf,
                                            const Run& run) {
  constexpr double kMostCells = 1e6;
  COLLINEA_TRY(const HeightField surface, open_height_field(heights));
  int times = 1;
  while (double(surface.grid.width) * surface.grid.height / (times * times) > kMostCells) ++times;
  const HeightField coarse = thinned(surface, times);
  CoarseTerrain terrain{.grid = coarse.grid, .usual_sigma_m = sigma_m};
  COLLINEA_TRY(terrain.height_m, coarse.read(0, 0, coarse.grid.width, coarse.grid.height));
  terrain.covered = Raster<std::uint8_t>(coarse.grid.width, coarse.grid.height);
  for (std::size_t i = 0; i < terrain.covered.data.size(); ++i)
    terrain.covered.data[i] = !std::isnan(terrain.height_m.data[i]);
  DrawnContours drawn{.interval_m = contour_interval_m(terrain)};
  if (drawn.interval_m == 0) {
    for (const auto& file : {geopackage, dxf}) COLLINEA_TRY(remove_file(file));
    return drawn;
  }
  COLLINEA_TRY(drawn.lines, draw_terrain_contours(std::move(terrain), drawn.interval_m, geopackage, dxf, run));
  return drawn;
}

}  // namespace collinea
