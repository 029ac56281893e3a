// SPDX-License-Identifier: Apache-2.0
#include "collinea/surface/dsm.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "collinea/base/memory.h"
#include "collinea/base/parallel.h"
#include "collinea/base/units.h"
#include "collinea/surface/internal/hole_filling.h"
#include "collinea/surface/internal/isolated_components.h"
#include "collinea/surface/internal/measured_tiles.h"
#include "collinea/surface/internal/point_buckets.h"

namespace collinea {
namespace {

constexpr double kWidestHoleCells = 250;  // trees and roofs that could not be matched, at the usual resolutions
constexpr double kWidestOfAll = 100'000;

constexpr int kBucketCells = 256;
constexpr int kTileCells = 512;
// What lies beyond is written to disk and read back once: caches of any size would not save that of large blocks.
constexpr std::size_t kPointMemory = std::size_t{64} << 20;
constexpr std::size_t kTileMemory = std::size_t{16} << 20;
constexpr double kMostCells = 2e10;
constexpr double kAlikePixels = 3.1;  // over which windows of 7 x 7 pixels make errors alike (docs/theory/surface.md)

int widest_hole_cells(const DsmOptions& options, double cell_m) {
  const double widest = options.fill_holes_m ? *options.fill_holes_m / cell_m : kWidestHoleCells;
  return int(std::min(std::floor(widest + 1e-9), kWidestOfAll));
}

// One batch on the map (by `frame`, or as it is when that is null) and in cells. Chunks are independent, so threads do
// not change the result.
std::vector<GridPoint> in_cells(const std::vector<SurfacePoint>& batch, const LocalFrame* frame, double cell_m,
                                const Run& run) {
  constexpr std::size_t kChunk = 16384;
  std::vector<GridPoint> points(batch.size());
  parallel_for(run, (batch.size() + kChunk - 1) / kChunk, [&](std::size_t chunk) {
    const std::size_t begin = chunk * kChunk, end = std::min(begin + kChunk, batch.size());
    std::vector<Eigen::Vector3d> positions;
    positions.reserve(end - begin);
    for (std::size_t i = begin; i < end; ++i) positions.push_back(batch[i].position);
    if (frame) frame->map_from_local(positions);
    for (std::size_t i = begin; i < end; ++i) {
      const Eigen::Vector3d& p = positions[i - begin];
      const float sigma_m = batch[i].sigma_m;
      points[i] = {p.x() / cell_m, -p.y() / cell_m, p.z(), sigma_m == 0 ? float(0.5 * cell_m) : sigma_m,
                   batch[i].images};
    }
  });
  return points;
}

bool usable(const GridPoint& p) {
  constexpr double kFarthest = 1e12;  // [cells]
  return std::abs(p.column) < kFarthest && std::abs(p.row) < kFarthest && std::isfinite(p.height_m) && p.sigma_m > 0;
}

Result<> collect(const SurfaceCloud& cloud, double cell_m, PointBuckets& buckets,
                 IsolatedComponents& isolated_components, DsmSummary& summary, const Run& run) {
  const LocalFrame* frame = cloud.point_frame == PointFrame::kMap ? nullptr : cloud.frame;
  std::vector<SurfacePoint> batch;
  for (;;) {
    COLLINEA_TRY(cloud.points(batch));
    if (batch.empty()) return {};
    std::vector<GridPoint> points = in_cells(batch, frame, cell_m, run);
    if (run.stopped()) return fail(Errc::kCancelled, "cancelled");
    summary.points += points.size();
    summary.points_dropped += std::erase_if(points, [](const GridPoint& p) { return !usable(p); });
    isolated_components.add(points);
    COLLINEA_TRY(buckets.add(points));
  }
}

// A few stray points far away would stretch the raster over the country: buckets with next to nothing, and nothing
// around them, go.
void drop_strays(PointBuckets& buckets, IsolatedComponents& isolated_components, DsmSummary& summary) {
  std::uint64_t most = 0;
  for (const auto& [square, bucket] : buckets.buckets()) most = std::max(most, bucket.count);
  const auto filled = [&](const PointBuckets::Square& square) {
    const auto found = buckets.buckets().find(square);
    return found != buckets.buckets().end() && found->second.count * 100 >= most;
  };
  std::vector<PointBuckets::Square> strays;
  for (const auto& [square, bucket] : buckets.buckets()) {
    bool near_filled = false;
    for (std::int64_t dy = -1; dy <= 1; ++dy)
      for (std::int64_t dx = -1; dx <= 1; ++dx) near_filled |= filled({square.column + dx, square.row + dy});
    if (near_filled) continue;
    strays.push_back(square);
    summary.points_dropped += bucket.count;
  }
  for (const auto& square : strays) {
    buckets.drop(square);
    isolated_components.forget({square.column * kBucketCells, square.row * kBucketCells, kBucketCells, kBucketCells});
  }
}

struct Extent {
  std::int64_t west, north, width, height;  // cells
};

Result<Extent> extent_of(const IsolatedComponents& isolated_components) {
  const auto [west, north, east, south] = isolated_components.bounds();
  const Extent extent{west, north, east - west + 1, south - north + 1};
  if (double(extent.width) * double(extent.height) > kMostCells || extent.width > 1'000'000 ||
      extent.height > 1'000'000)
    return fail(Errc::kBadInput, "the surface model would have " + std::to_string(extent.width) + " x " +
                                     std::to_string(extent.height) + " cells: choose a larger cell_m");
  return extent;
}

void tally(const SurfaceTile& tile, DsmSummary& summary) {
  for (std::size_t i = 0; i < tile.state.data.size(); ++i) {
    const auto state = CellState(tile.state.data[i]);
    summary.empty_cells += state == CellState::kEmpty;
    summary.interpolated_cells += state == CellState::kInterpolated;
    if (state != CellState::kMeasured) continue;
    const double height_m = tile.height_m.data[i], sigma_m = tile.sigma_m.data[i],
                 relative_m = tile.sigma_relative_m.data[i];
    const bool first = summary.measured_cells++ == 0;
    summary.lowest_m = first ? height_m : std::min(summary.lowest_m, height_m);
    summary.highest_m = first ? height_m : std::max(summary.highest_m, height_m);
    summary.mean_sigma_m += sigma_m * sigma_m;
    summary.mean_sigma_relative_m += relative_m * relative_m;
  }
}

CellWindow widened(const CellWindow& window, int margin) {
  return {window.column - margin, window.row - margin, window.width + 2 * margin, window.height + 2 * margin};
}

// Measures a square of the model and shows it to `holes`. Without points: no rasters.
Result<SurfaceTile> measured_tile(const PointBuckets& buckets, const IsolatedComponents& isolated_components,
                                  const CellWindow& square, const Gridding& gridding, HoleFilling& holes) {
  constexpr int kRim = HoleFilling::kRim;
  const CellWindow wide = widened(square, kRim);
  const auto points_of = [&](const CellWindow& band) -> Result<std::vector<GridPoint>> {
    COLLINEA_TRY(auto points, buckets.points_in(band));
    std::erase_if(points, [&](const GridPoint& point) { return isolated_components.holds(point); });
    return points;
  };
  COLLINEA_TRY(const SurfaceTile tile, measure_window(points_of, wide, gridding));
  if (tile.state.empty()) return tile;
  holes.add(tile, square);
  return cropped(tile, {kRim, kRim, square.width, square.height});
}

Result<> measure_all(const PointBuckets& buckets, const IsolatedComponents& isolated_components, const Extent& extent,
                     const Gridding& gridding, MeasuredTiles& tiles, HoleFilling& holes, const Run& run) {
  constexpr int kCells = MeasuredTiles::kCells;
  static_assert(kCells % HoleFilling::kBlock == 0);
  UnitList list{.stage = "surface", .end = 0.8};
  for (std::int64_t row = floor_div(extent.north, kCells); row * kCells < extent.north + extent.height; ++row)
    for (std::int64_t column = floor_div(extent.west, kCells); column * kCells < extent.west + extent.width; ++column)
      list.units.push_back(Unit::tile(column, row));
  return run_units_in_order(
      run, list,
      [&](const Unit& unit) {
        const CellWindow square{unit.first * kCells, unit.second * kCells, kCells, kCells};
        return measured_tile(buckets, isolated_components, square, gridding, holes);
      },
      [&](const Unit& unit, SurfaceTile tile) -> Result<> {
        return tile.state.empty() ? Result<>{} : tiles.add({unit.first, unit.second}, std::move(tile));
      });
}

Result<> fill_windows(const MeasuredTiles& tiles, const Extent& extent, const HoleFilling& holes,
                      const OrientationSigma& orientation, const SurfaceSink& sink, DsmSummary& summary,
                      const Run& run) {
  const UnitList list{"surface", tiles_over(extent.width, extent.height, kTileCells, kTileCells), 0.8, 1};
  return run_units_in_order(
      run, list,
      [&](const Unit& unit) -> Result<SurfaceTile> {
        const std::int64_t x = unit.first * kTileCells, y = unit.second * kTileCells;
        const CellWindow window{extent.west + x, extent.north + y,
                                int(std::min<std::int64_t>(kTileCells, extent.width - x)),
                                int(std::min<std::int64_t>(kTileCells, extent.height - y))};
        COLLINEA_TRY(const SurfaceTile measured, tiles.window(HoleFilling::with_margin(window)));
        SurfaceTile tile = holes.filled(measured, window);
        tile.sigma_relative_m = tile.sigma_m;
        orientation.add_to(tile.sigma_m, window);
        return tile;
      },
      [&](const Unit& unit, const SurfaceTile& tile) {
        tally(tile, summary);
        return sink.take(int(unit.first * kTileCells), int(unit.second * kTileCells), tile);
      });
}

Result<> make_model(const SurfaceCloud& cloud, const PointBuckets& buckets,
                    const IsolatedComponents& isolated_components, const Extent& extent, int widest_hole,
                    const SurfaceSink& sink, const std::filesystem::path& scratch, DsmSummary& summary,
                    const Run& run) {
  const double cell_m = summary.grid.cell_m;
  const Gridding gridding{.cell_m = cell_m, .alike_cells = kAlikePixels * std::max(0.0, cloud.gsd_m) / cell_m};
  MeasuredTiles tiles(scratch, kTileMemory);
  HoleFilling holes(extent.west, extent.north, extent.width, extent.height, cell_m, widest_hole);
  COLLINEA_TRY(measure_all(buckets, isolated_components, extent, gridding, tiles, holes, run));
  holes.prepare();
  give_back_freed_memory();
  const OrientationSigma orientation(cloud.position_sigmas,
                                     {extent.west, extent.north, int(extent.width), int(extent.height)}, cell_m);
  return fill_windows(tiles, extent, holes, orientation, sink, summary, run);
}

}  // namespace

double tidy_cell_m(double gsd_m) {
  const double unit = std::pow(10.0, std::floor(std::log10(gsd_m)) - 1);
  // Dividing by a whole power of ten gives the decimal number nearest to what is meant: 0.024, not
  // 0.024000000000000004.
  return unit < 1 ? std::round(gsd_m / unit) / std::round(1 / unit) : std::round(gsd_m / unit) * unit;
}

Result<DsmSummary> build_dsm(const SurfaceCloud& cloud, const SurfaceSink& sink, const std::filesystem::path& scratch,
                             const DsmOptions& options, const Run& run) {
  COLLINEA_TRY(validate(options));
  if (!options.cell_m && !(cloud.gsd_m > 0 && std::isfinite(cloud.gsd_m)))
    return fail(Errc::kBadInput, "neither cell_m nor the ground size of a pixel is known");
  const double cell_m = options.cell_m ? *options.cell_m : tidy_cell_m(cloud.gsd_m);
  PointBuckets buckets(scratch, kBucketCells, kPointMemory);
  IsolatedComponents isolated_components;
  DsmSummary summary;
  COLLINEA_TRY(collect(cloud, cell_m, buckets, isolated_components, summary, run));
  drop_strays(buckets, isolated_components, summary);
  summary.points_dropped += isolated_components.find(cell_m);
  COLLINEA_TRY(buckets.finish());
  give_back_freed_memory();
  if (buckets.buckets().empty()) return fail(Errc::kIllPosed, "no points for a surface model");
  COLLINEA_TRY(const Extent extent, extent_of(isolated_components));
  summary.grid.cell_m = cell_m;
  summary.grid.west_m = double(extent.west) * cell_m;
  summary.grid.north_m = -double(extent.north) * cell_m;
  summary.grid.width = int(extent.width), summary.grid.height = int(extent.height);
  summary.grid.wkt = cloud.frame ? cloud.frame->wkt1() : cloud.wkt;
  COLLINEA_TRY(sink.begin(summary.grid));
  if (auto made = make_model(cloud, buckets, isolated_components, extent, widest_hole_cells(options, cell_m), sink,
                             scratch, summary, run);
      !made)
    return tl::unexpected(std::move(made).error());
  if (summary.measured_cells > 0)
    for (double* mean : {&summary.mean_sigma_m, &summary.mean_sigma_relative_m})
      *mean = std::sqrt(*mean / double(summary.measured_cells));
  return summary;
}

}  // namespace collinea
