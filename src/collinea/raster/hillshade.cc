// SPDX-License-Identifier: Apache-2.0
#include "collinea/raster/hillshade.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "collinea/raster/band_descriptions.h"
#include "collinea/raster/block_cache.h"
#include "collinea/raster/geotiff.h"

namespace collinea {
namespace {

constexpr int kTile = 512;

Raster<std::uint8_t> shaded(const FloatImage& heights_m, double cell_m, int left, int top, int width, int height) {
  Raster<std::uint8_t> image(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      if (const double light = hillshade_at(heights_m, left + x, top + y, cell_m); !std::isnan(light))
        image.at(x, y) = std::uint8_t(std::lround(1 + 254 * light));
  return image;
}

}  // namespace

double hillshade_at(const FloatImage& heights_m, int x, int y, double cell_m) {
  const double middle = double(heights_m.at(x, y));
  if (std::isnan(middle)) return middle;
  const auto height = [&](int dx, int dy) {
    const int u = x + dx, v = y + dy;
    if (u < 0 || v < 0 || u >= heights_m.width || v >= heights_m.height) return middle;
    const float there = heights_m.at(u, v);
    return std::isnan(there) ? middle : double(there);
  };
  const double west = height(-1, -1) + 2 * height(-1, 0) + height(-1, 1);
  const double east = height(1, -1) + 2 * height(1, 0) + height(1, 1);
  const double north = height(-1, -1) + 2 * height(0, -1) + height(1, -1);
  const double south = height(-1, 1) + 2 * height(0, 1) + height(1, 1);
  const double to_east = (east - west) / (8 * cell_m), to_north = (north - south) / (8 * cell_m);
  // The normal (-to_east, -to_north, 1) times the light (-1/2, 1/2, 1/sqrt 2).
  const double along = (to_east - to_north) / 2 + 1 / std::numbers::sqrt2;
  return std::max(0.0, along / std::sqrt(1 + to_east * to_east + to_north * to_north));
}

Result<> write_hillshade(const std::filesystem::path& heights, const std::filesystem::path& out, const Run& run) {
  COLLINEA_TRY(const GeoTiffReader reader, GeoTiffReader::open(heights));
  const MapGrid& grid = reader.grid();
  GeoTiffWriter<std::uint8_t>::Options options;
  options.nodata = 0;
  options.cloud_optimised = true;  // by one thread: more hold 35 MB of a large raster in pieces
  options.description = band::kHillshade;
  COLLINEA_TRY(auto writer, GeoTiffWriter<std::uint8_t>::create(out, grid, 1, options));
  for (int row = 0; row < grid.height; row += kTile) {
    for (int column = 0; column < grid.width; column += kTile) {
      if (run.stopped()) return fail(Errc::kCancelled, "stopped");
      const int left = std::max(0, column - 1), top = std::max(0, row - 1);
      const int width = std::min(kTile, grid.width - column), height = std::min(kTile, grid.height - row);
      COLLINEA_TRY(const FloatImage around,
                   reader.read_known(left, top, std::min(grid.width, column + width + 1) - left,
                                     std::min(grid.height, row + height + 1) - top));
      const auto image = shaded(around, grid.cell_m, column - left, row - top, width, height);
      COLLINEA_TRY(writer.write(column, row, image));
    }
  }
  // Overviews are made of rows of the whole width, beside what is in the cache: each block is looked at once.
  const BlockCacheLimit cache(kCacheOfPieces / 4);
  return writer.finish();
}

}  // namespace collinea
