// SPDX-License-Identifier: Apache-2.0
#include "collinea/surface/height_field.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <mutex>
#include <utility>

#include "collinea/raster/geotiff.h"
#include "collinea/raster/raster_spool.h"

namespace collinea {
namespace {

using ReadFloats = std::function<Result<FloatImage>(int column, int row, int width, int height)>;

Result<ReadFloats> open_floats(const std::filesystem::path& path, MapGrid& grid) {
  struct Shared {
    std::mutex mutex;
    GeoTiffReader reader;
  };
  COLLINEA_TRY(GeoTiffReader reader, GeoTiffReader::open(path));
  const auto shared = std::shared_ptr<Shared>(new Shared{{}, std::move(reader)});
  grid = shared->reader.grid();
  return [shared](int column, int row, int width, int height) -> Result<FloatImage> {
    const std::lock_guard lock(shared->mutex);
    return shared->reader.read_known(column, row, width, height);
  };
}

// That the standard deviations are of other cells than the heights.
Error not_of_one_model(const std::filesystem::path& path, const MapGrid& heights,
                       const std::filesystem::path& sigma_path, const MapGrid& sigmas) {
  return Error{
      Errc::kBadInput,
      fmt::format("{} ({} x {} cells of {} m from {:.3f} east, {:.3f} north) does not lie on {} ({} x {} cells of {} m "
                  "from {:.3f} east, {:.3f} north): the two are not of one surface model",
                  sigma_path.string(), sigmas.width, sigmas.height, sigmas.cell_m, sigmas.west_m, sigmas.north_m,
                  path.string(), heights.width, heights.height, heights.cell_m, heights.west_m, heights.north_m)};
}

constexpr float kNothing = -std::numeric_limits<float>::infinity();

void add_strip(const FloatImage& strip, int first_row, HeightOverview& result) {
  constexpr int kBlock = HeightOverview::kBlock;
  const int block_row = first_row / kBlock;
  for (int block = 0; block < result.lowest_m.width; ++block) {
    float low = std::numeric_limits<float>::infinity(), high = kNothing;
    SurfaceSample sample;
    int nearest = std::numeric_limits<int>::max();
    for (int y = 0; y < strip.height; ++y) {
      for (int x = block * kBlock; x < std::min((block + 1) * kBlock, strip.width); ++x) {
        const float z = strip.at(x, y);
        if (std::isnan(z)) continue;
        low = std::min(low, z), high = std::max(high, z);
        const int dx = x - block * kBlock - kBlock / 2, dy = y - kBlock / 2;
        if (dx * dx + dy * dy >= nearest) continue;
        nearest = dx * dx + dy * dy;
        sample = {x + 0.5, first_row + y + 0.5, z};
      }
    }
    if (high == kNothing) continue;
    result.lowest_m.at(block, block_row) = low;
    result.highest_m.at(block, block_row) = high;
    result.samples.push_back(sample);
  }
}

using ReadHeights = std::function<Result<FloatImage>(int column, int row, int width, int height)>;

ReadHeights read_thinned(const ReadHeights& read, const MapGrid& grid, int times) {
  return [read, times, columns = grid.width, rows = grid.height](int column, int row, int width,
                                                                 int height) -> Result<FloatImage> {
    FloatImage result(width, height);
    const auto from = [times](int cell, int cells) { return std::min(cell * times + times / 2, cells - 1); };
    const int left = from(column, columns), right = from(column + width - 1, columns) + 1;
    constexpr int kStrip = 64;
    for (int strip = 0; strip < height; strip += kStrip) {
      const int end = std::min(strip + kStrip, height);
      const int top = from(row + strip, rows), bottom = from(row + end - 1, rows) + 1;
      COLLINEA_TRY(const FloatImage fine, read(left, top, right - left, bottom - top));
      for (int y = strip; y < end; ++y)
        for (int x = 0; x < width; ++x)
          result.at(x, y) = fine.at(from(column + x, columns) - left, from(row + y, rows) - top);
    }
    return result;
  };
}

Result<> append(const ReadHeights& read, const MapGrid& grid, RasterSpool& rasters, const Run& run) {
  constexpr int kStrip = 64;
  for (int row = 0; row < grid.height; row += kStrip) {
    if (run.stopped()) return fail(Errc::kCancelled, "cancelled");
    COLLINEA_TRY(const FloatImage strip, read(0, row, grid.width, std::min(kStrip, grid.height - row)));
    rasters.append(strip);
  }
  return {};
}

}  // namespace

Result<HeightField> open_height_field(const std::filesystem::path& path, const std::filesystem::path& sigma_path) {
  HeightField field;
  COLLINEA_TRY(field.read, open_floats(path, field.grid));
  if (sigma_path.empty() || !std::filesystem::exists(sigma_path)) return field;
  MapGrid grid;
  COLLINEA_TRY(field.read_sigma, open_floats(sigma_path, grid));
  if (!same_cells(field.grid, grid)) return tl::unexpected(not_of_one_model(path, field.grid, sigma_path, grid));
  return field;
}

Result<HeightField> unpacked(const HeightField& field, const std::filesystem::path& beside, const Run& run) {
  COLLINEA_TRY(RasterSpool spool, RasterSpool::create(beside, field.grid.width, field.grid.height));
  const auto rasters = std::make_shared<RasterSpool>(std::move(spool));
  auto written = append(field.read, field.grid, *rasters, run);
  if (written && field.read_sigma) written = append(field.read_sigma, field.grid, *rasters, run);
  if (!written) return tl::unexpected(std::move(written).error());
  const auto reader = [rasters](int raster) {
    return [rasters, raster](int column, int row, int width, int height) {
      return rasters->read(raster, column, row, width, height);
    };
  };
  HeightField result{field.grid, reader(0), {}};
  if (field.read_sigma) result.read_sigma = reader(1);
  return result;
}

HeightField thinned(const HeightField& field, int times) {
  HeightField result;
  result.grid = field.grid;
  result.grid.cell_m *= times;
  result.grid.width = (field.grid.width + times - 1) / times;
  result.grid.height = (field.grid.height + times - 1) / times;
  result.read = read_thinned(field.read, field.grid, times);
  if (field.read_sigma) result.read_sigma = read_thinned(field.read_sigma, field.grid, times);
  return result;
}

Result<HeightOverview> overview(const HeightField& field, const Run& run) {
  constexpr int kBlock = HeightOverview::kBlock;
  const float none = std::numeric_limits<float>::quiet_NaN();
  HeightOverview result;
  result.lowest_m =
      FloatImage((field.grid.width + kBlock - 1) / kBlock, (field.grid.height + kBlock - 1) / kBlock, 1, none);
  result.highest_m = result.lowest_m;
  // Strips as high as a row of TIFF tiles, so that each tile is unpacked once.
  constexpr int kStrip = 8 * kBlock;
  for (int row = 0; row < field.grid.height; row += kStrip) {
    if (run.stopped()) return fail(Errc::kCancelled, "cancelled");
    COLLINEA_TRY(const FloatImage strip,
                 field.read(0, row, field.grid.width, std::min(kStrip, field.grid.height - row)));
    for (int part = 0; part < strip.height; part += kBlock) {
      FloatImage rows(strip.width, std::min(kBlock, strip.height - part));
      std::copy_n(strip.row(part), rows.data.size(), rows.data.begin());
      add_strip(rows, row + part, result);
    }
  }
  for (const SurfaceSample& sample : result.samples) result.mean_m += sample.height_m;
  if (!result.samples.empty()) result.mean_m /= double(result.samples.size());
  return result;
}

float height_at(const FloatImage& heights_m, double x, double y, double cell_m) {
  const int column = int(std::floor(x)), row = int(std::floor(y));
  if (column < 0 || row < 0 || column >= heights_m.width || row >= heights_m.height)
    return std::numeric_limits<float>::quiet_NaN();
  const float nearest = heights_m.at(column, row);
  const int x0 = int(std::floor(x - 0.5)), y0 = int(std::floor(y - 0.5));
  if (std::isnan(nearest) || x0 < 0 || y0 < 0 || x0 + 1 >= heights_m.width || y0 + 1 >= heights_m.height)
    return nearest;
  const float *upper = heights_m.row(y0) + x0, *lower = heights_m.row(y0 + 1) + x0;
  const float high = std::max(std::max(upper[0], upper[1]), std::max(lower[0], lower[1]));
  const float low = std::min(std::min(upper[0], upper[1]), std::min(lower[0], lower[1]));
  if (!(high - low <= 2 * cell_m) || std::isnan(upper[0] + upper[1] + lower[0] + lower[1])) return nearest;
  const float a = float(x - 0.5 - x0), b = float(y - 0.5 - y0);
  return (1 - b) * ((1 - a) * upper[0] + a * upper[1]) + b * ((1 - a) * lower[0] + a * lower[1]);
}

}  // namespace collinea
