// SPDX-License-Identifier: Apache-2.0
#include "collinea/ortho/rectify.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "collinea/base/file.h"
#include "collinea/base/parallel.h"
#include "collinea/io/text.h"
#include "collinea/ortho/ortho_tile.h"
#include "collinea/raster/band_descriptions.h"
#include "collinea/raster/image_file.h"

namespace collinea {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kBand = 512;  // rows made at once
constexpr std::size_t kImageBytes = std::size_t{512} << 20;

}  // namespace

std::optional<Vector2d> pixel_of(const PlaneView& view, const Vector2d& on_plane_m) {
  const Vector3d ray = view.cam_from_plane * on_plane_m.homogeneous();
  if (!(ray.z() > 1e-9 * ray.norm())) return {};
  const auto pixel = project(view.camera, view.bend.bent(ray));
  return pixel && inside(view.camera, *pixel) ? pixel : std::nullopt;
}

double pixel_size_m(const PlaneView& view, const Vector2d& on_plane_m) {
  constexpr double kNothing = std::numeric_limits<double>::infinity();
  if (!pixel_of(view, on_plane_m)) return kNothing;
  const Vector3d ray = view.cam_from_plane * on_plane_m.homogeneous();
  const Eigen::Matrix2d units_per_m =
      (view.cam_from_plane.topLeftCorner<2, 2>() - ray.hnormalized() * view.cam_from_plane.bottomLeftCorner<1, 2>()) /
      ray.z();
  const double pixels = pixels_per_unit(view.camera, ray.hnormalized());
  const double area = std::abs(units_per_m.determinant()) * pixels * pixels;
  return area > 0 ? 1 / std::sqrt(area) : kNothing;
}

std::optional<double> shift_per_depth(const PlaneView& view, const Vector2d& on_plane_m) {
  if (!view.centre_over_plane || !(view.centre_over_plane->z() > 0)) return {};
  return (on_plane_m - view.centre_over_plane->head<2>()).norm() / view.centre_over_plane->z();
}

std::vector<PlaneView> views_for(std::span<const PlaneView> views, const PlaneExtent& extent) {
  constexpr int kSamples = 9;
  std::vector<Vector2d> open;
  for (int i = 0; i < kSamples * kSamples; ++i)
    open.push_back(extent.at(double(i % kSamples) / (kSamples - 1), double(i / kSamples) / (kSamples - 1)));
  std::vector<PlaneView> chosen;
  for (;;) {
    const PlaneView* best = nullptr;
    double most = 0;
    for (const PlaneView& view : views) {
      double worth = 0;
      for (const Vector2d& position : open) {
        const double size_m = pixel_size_m(view, position);
        const double slope = shift_per_depth(view, position).value_or(0);
        if (std::isfinite(size_m)) worth += 1 / (size_m * (1 + slope * slope));
      }
      if (worth > most) most = worth, best = &view;
    }
    if (!best) return chosen;
    chosen.push_back(*best);
    std::erase_if(open, [&](const Vector2d& position) { return pixel_of(*best, position).has_value(); });
  }
}

Result<MapGrid> plane_grid(const PlaneExtent& extent, double cell_m) {
  const Vector2d cells = (extent.size() / cell_m).array().ceil();
  if (!(cells.x() >= 1 && cells.y() >= 1 && cell_m > 0))
    return fail(Errc::kBadInput, "the area to be rectified has no extent");
  if (!(cells.x() < 1e6 && cells.y() < 1e6 && cells.x() * cells.y() < 2147483648.0))
    return fail(Errc::kBadInput, "the rectified image would have too many cells: give a larger cell or a smaller area");
  MapGrid grid;
  grid.cell_m = cell_m;
  grid.width = int(cells.x());
  grid.height = int(cells.y());
  grid.west_m = extent.lowest.x();
  grid.north_m = extent.lowest.y() + grid.height * cell_m;
  return grid;
}

// --- the image -----------------------------------------------------------------------------------------------------

namespace {

int shrink_for(const PlaneView& view, const MapGrid& grid) {
  double smallest = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 25; ++i)
    smallest = std::min(smallest, pixel_size_m(view, {grid.east_of(grid.width * (i % 5) / 4.0),
                                                      grid.north_of(grid.height * (i / 5) / 4.0)}));
  int shrink = 1;
  while (shrink < 8 && std::isfinite(smallest) && 2 * shrink * smallest <= grid.cell_m) shrink *= 2;
  return shrink;
}

// Some cell of a band that is still empty lies in the image.
bool shows_some(const PlaneView& view, const MapGrid& grid, int top, const Raster<std::uint8_t>& rgba) {
  for (int y = 0; y < rgba.height; ++y)
    for (int x = 0; x < grid.width; ++x)
      if (!rgba.at(x, y, 3) && pixel_of(view, {grid.east_of(x + 0.5), grid.north_of(top + y + 0.5)})) return true;
  return false;
}

struct Painter {
  const MapGrid& grid;
  std::span<const PlaneView> views;
  std::vector<int> shrinks;
  PixelCache& images;
  const Run& run;

  // Rows [top, top + rows). Counts what each view painted.
  Result<Raster<std::uint8_t>> band(int top, int rows, std::vector<std::uint64_t>& cells_of) {
    Raster<std::uint8_t> rgba(grid.width, rows, 4);
    for (std::size_t v = 0; v < views.size(); ++v) {
      const PlaneView& view = views[v];
      if (!shows_some(view, grid, top, rgba)) continue;
      COLLINEA_TRY(const auto image, images.image_of(view.image, shrinks[v]));
      const double across = double(image->width) / view.camera.width_px;
      const double down = double(image->height) / view.camera.height_px;
      std::vector<std::uint64_t> painted(std::size_t(rows), 0);
      parallel_for(run, std::size_t(rows), [&](std::size_t y) {
        std::uint8_t* cell = rgba.row(int(y));
        for (int x = 0; x < grid.width; ++x, cell += 4) {
          if (cell[3]) continue;
          const auto pixel = pixel_of(view, {grid.east_of(x + 0.5), grid.north_of(top + double(y) + 0.5)});
          if (!pixel) continue;
          float colour[3];
          bicubic(*image, pixel->x() * across, pixel->y() * down, colour);
          for (int c = 0; c < 3; ++c) cell[c] = std::uint8_t(std::lround(std::clamp(colour[c], 0.0f, 255.0f)));
          cell[3] = 255;
          ++painted[y];
        }
      });
      for (const std::uint64_t count : painted) cells_of[v] += count;
    }
    if (run.stopped()) return fail(Errc::kCancelled, "cancelled");
    return rgba;
  }
};

// The six numbers of a world file: cell, turns, cell, centre of the upper left cell.
std::string world_file(const MapGrid& grid) {
  std::string text;
  for (const double number : {grid.cell_m, 0.0, 0.0, -grid.cell_m, grid.east_of(0.5), grid.north_of(0.5)})
    text += exact(number) + "\n";
  return text;
}

}  // namespace

Result<RectifiedSummary> write_rectified(const std::filesystem::path& path, const MapGrid& grid,
                                         std::span<const PlaneView> views, const PixelSource& pixels, const Run& run) {
  PixelCache images(pixels, kImageBytes);
  Painter painter{grid, views, {}, images, run};
  for (const PlaneView& view : views) painter.shrinks.push_back(shrink_for(view, grid));
  RectifiedSummary summary;
  summary.cells_of.resize(views.size());
  const bool png = lower(path.extension().string()) == ".png";
  std::optional<GeoTiffWriter<std::uint8_t>> tiff;
  Raster<std::uint8_t> whole;
  if (png) {
    whole = Raster<std::uint8_t>(grid.width, grid.height, 4);
  } else {
    GeoTiffWriter<std::uint8_t>::Options options;
    options.alpha = true, options.cloud_optimised = true;
    options.description = band::kRectified;
    options.threads = run.threads;
    COLLINEA_TRY(tiff, GeoTiffWriter<std::uint8_t>::create(path, grid, 4, options));
  }
  for (int top = 0; top < grid.height; top += kBand) {
    const int rows = std::min(kBand, grid.height - top);
    COLLINEA_TRY(const Raster<std::uint8_t> band, painter.band(top, rows, summary.cells_of));
    run.report("rectify", double(top + rows) / grid.height);
    if (png) {
      std::copy(band.data.begin(), band.data.end(), whole.row(top));
      continue;
    }
    COLLINEA_TRY(tiff->write(0, top, band));
  }
  for (const std::uint64_t cells : summary.cells_of) summary.painted_cells += cells;
  if (summary.painted_cells == 0) return fail(Errc::kIllPosed, "no photograph shows the area to be rectified");
  if (png) {
    COLLINEA_TRY(write_png(path, whole));
    std::filesystem::path world = path;
    COLLINEA_TRY(write_file(world.replace_extension(".pgw"), world_file(grid)));
  } else if (auto finished = tiff->finish(); !finished) {
    return tl::unexpected(finished.error());
  }
  summary.empty_cells = std::uint64_t(grid.width) * std::uint64_t(grid.height) - summary.painted_cells;
  return summary;
}

}  // namespace collinea
