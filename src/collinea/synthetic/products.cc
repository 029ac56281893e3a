// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>

#include "collinea/base/parallel.h"
#include "collinea/raster/band_descriptions.h"
#include "collinea/raster/geotiff.h"
#include "collinea/synthetic/render.h"
#include "collinea/synthetic/write.h"

namespace collinea {
namespace {

constexpr int kTile = 128;  // cells; over so little ground map and world differ by an affinity, to 1e-6 m
constexpr float kNoHeight = -9999;

MapGrid grid_of(const Truth& truth, double cell_m) {
  const auto& [low, high] = *truth.mapped;
  Eigen::Vector3d least = Eigen::Vector3d::Constant(1e30), most = -least;
  for (const Eigen::Vector3d& corner : {Eigen::Vector3d(low.x(), low.y(), 0),
                                        {high.x(), low.y(), 0},
                                        {low.x(), high.y(), 0},
                                        {high.x(), high.y(), 0}}) {
    const Eigen::Vector3d on_map = truth.frame.map_from_local(corner);
    least = least.cwiseMin(on_map);
    most = most.cwiseMax(on_map);
  }
  MapGrid grid;
  grid.cell_m = cell_m;
  grid.west_m = std::floor(least.x() / cell_m) * cell_m;
  grid.north_m = std::ceil(most.y() / cell_m) * cell_m;
  grid.width = int(std::ceil((most.x() - grid.west_m) / cell_m));
  grid.height = int(std::ceil((grid.north_m - least.y()) / cell_m));
  grid.wkt = truth.frame.wkt1();
  return grid;
}

// The plumb lines through the cells of a tile: where they pass a height above all surfaces, and their common direction.
struct PlumbLines {
  Eigen::Vector3d corner, by_column, by_row;  // corner: centre of the tile's first cell
  Eigen::Vector3d down;
  double top_m;  // map height of the plane they start from
};

PlumbLines plumb_lines(const LocalFrame& frame, const MapGrid& grid, int column, int row, double top_m) {
  const double e = grid.east_of(column + 0.5), n = grid.north_of(row + 0.5), size_m = kTile * grid.cell_m;
  std::array<Eigen::Vector3d, 4> points = {
      {{e, n, top_m}, {e + size_m, n, top_m}, {e, n - size_m, top_m}, {e, n, top_m - 100}}};
  frame.local_from_map(points);
  return {points[0], (points[1] - points[0]) / kTile, (points[2] - points[0]) / kTile, (points[3] - points[0]) / 100,
          top_m};
}

struct Strip {
  FloatImage heights, terrain;
  ColourImage colours;
};

// Where a plumb line that starts at `start` meets the terrain, which is never steep: three rounds are more than enough.
float terrain_height(const Scene& scene, const PlumbLines& lines, const Eigen::Vector3d& start) {
  double fallen_m = 0;
  for (int round = 0; round < 3; ++round) {
    const Eigen::Vector3d at = start + fallen_m * lines.down;
    fallen_m += (at.z() - scene.terrain_height(at.x(), at.y())) / -lines.down.z();
  }
  return float(lines.top_m - fallen_m);
}

void fill_tile(const Truth& truth, const PlumbLines& lines, double cell_m, int column, Strip& strip) {
  const double along = lines.down.norm();  // metres of the world in a metre of map height
  for (int y = 0; y < strip.heights.height; ++y)
    for (int x = column; x < std::min(column + kTile, strip.heights.width); ++x) {
      const Eigen::Vector3d start = lines.corner + (x - column) * lines.by_column + y * lines.by_row;
      strip.terrain.at(x, y) = terrain_height(truth.scene, lines, start);
      const auto hit = truth.scene.cast(start, lines.down / along);
      if (!hit) continue;
      strip.heights.at(x, y) = float(lines.top_m - hit->distance_m / along);
      const Colour colour = truth.scene.shaded(*hit, cell_m, truth.scene.in_sun(hit->point, hit->normal));
      strip.colours.at(x, y, 0) = std::uint8_t(std::lround(tone(colour.r)));
      strip.colours.at(x, y, 1) = std::uint8_t(std::lround(tone(colour.g)));
      strip.colours.at(x, y, 2) = std::uint8_t(std::lround(tone(colour.b)));
      strip.colours.at(x, y, 3) = 255;
    }
}

}  // namespace

Result<> write_products(const Truth& truth, const std::filesystem::path& folder, double cell_m, const Run& run) {
  if (!truth.mapped) return {};
  const MapGrid grid = grid_of(truth, cell_m);
  GeoTiffWriter<float>::Options dsm_options;
  dsm_options.nodata = kNoHeight;
  dsm_options.description = band::kTrueSurfaceHeight;
  GeoTiffWriter<std::uint8_t>::Options ortho_options;
  ortho_options.alpha = true;
  ortho_options.description = band::kTrueOrthophoto;
  COLLINEA_TRY(auto dsm, GeoTiffWriter<float>::create(folder / "dsm.tif", grid, 1, dsm_options));
  dsm_options.description = band::kTrueTerrainHeight;
  COLLINEA_TRY(auto dtm, GeoTiffWriter<float>::create(folder / "dtm.tif", grid, 1, dsm_options));
  COLLINEA_TRY(auto ortho, GeoTiffWriter<std::uint8_t>::create(folder / "ortho.tif", grid, 4, ortho_options));

  const double top_m = truth.frame.map_from_local({0, 0, truth.scene.highest_m() + 5}).z();
  const std::size_t tiles = std::size_t((grid.width + kTile - 1) / kTile);
  for (int row = 0; row < grid.height; row += kTile) {
    const int rows = std::min(kTile, grid.height - row);
    Strip strip{FloatImage(grid.width, rows, 1, kNoHeight), FloatImage(grid.width, rows, 1, kNoHeight),
                ColourImage(grid.width, rows, 4)};
    parallel_for(run, tiles, [&](std::size_t tile) {
      const int column = int(tile) * kTile;
      fill_tile(truth, plumb_lines(truth.frame, grid, column, row, top_m), cell_m, column, strip);
    });
    if (run.stopped()) return fail(Errc::kCancelled, "writing the true surface was stopped");
    COLLINEA_TRY(dsm.write(0, row, strip.heights));
    COLLINEA_TRY(dtm.write(0, row, strip.terrain));
    COLLINEA_TRY(ortho.write(0, row, strip.colours));
    run.report("true surface", double(row + rows) / grid.height);
  }
  COLLINEA_TRY(dsm.finish());
  COLLINEA_TRY(dtm.finish());
  return ortho.finish();
}

}  // namespace collinea
