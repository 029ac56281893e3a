// SPDX-License-Identifier: Apache-2.0
#include "collinea/ortho/ortho_scene.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace collinea {
namespace {

constexpr int kFarthestOccluder = 2048;  // [surface cells]

struct HeightRange {
  float low_m = std::numeric_limits<float>::infinity(), high_m = -std::numeric_limits<float>::infinity();
  [[nodiscard]] bool empty() const { return !(low_m <= high_m); }
};

// The part of the surface under an area of the orthophoto, with a margin, cut at the border of the raster.
CellArea surface_area(const OrthoScene& scene, const CellArea& area, int margin) {
  const MapGrid &from = scene.grid, &to = scene.surface->grid;
  const auto column = [&](double c) { return to.column_of(from.east_of(c)); };
  const auto row = [&](double r) { return to.row_of(from.north_of(r)); };
  const int left = std::clamp(int(std::floor(column(area.column))) - margin, 0, to.width);
  const int right = std::clamp(int(std::ceil(column(area.column + area.width))) + margin, 0, to.width);
  const int top = std::clamp(int(std::floor(row(area.row))) - margin, 0, to.height);
  const int bottom = std::clamp(int(std::ceil(row(area.row + area.height))) + margin, 0, to.height);
  return {left, top, right - left, bottom - top};
}

template <class Visit>
void each_block(const HeightOverview& overview, const CellArea& surface, Visit&& visit) {
  constexpr int kBlock = HeightOverview::kBlock;
  if (surface.width <= 0 || surface.height <= 0) return;
  for (int y = surface.row / kBlock; y <= (surface.row + surface.height - 1) / kBlock; ++y)
    for (int x = surface.column / kBlock; x <= (surface.column + surface.width - 1) / kBlock; ++x)
      if (!std::isnan(overview.highest_m.at(x, y))) visit(x, y);
}

HeightRange heights_under(const HeightOverview& overview, const CellArea& surface) {
  HeightRange range;
  each_block(overview, surface, [&](int x, int y) {
    range.low_m = std::min(range.low_m, overview.lowest_m.at(x, y));
    range.high_m = std::max(range.high_m, overview.highest_m.at(x, y));
  });
  return range;
}

// Views that show something of the patch, by a coarse look at 5 x 5 places, lowest and highest.
std::vector<std::size_t> views_over(const OrthoScene& scene, const WorldLattice& lattice, const CellArea& area,
                                    const HeightRange& range) {
  std::vector<std::size_t> found;
  const double stride_cells = std::max(area.width, area.height) / 4.0;
  for (std::size_t v = 0; v < scene.views.size(); ++v) {
    const View& view = scene.views[v];
    bool shows = false;
    for (int place = 0; place < 50 && !shows; ++place) {
      const double x = area.width * (place % 5) / 4.0, y = area.height * (place / 5 % 5) / 4.0;
      const Eigen::Vector3d at = lattice.at(x, y, double(place < 25 ? range.low_m : range.high_m));
      const auto pixel = pixel_of(view, at);
      if (!pixel) continue;
      const double distance_m = (view.centre_in_world - at).norm();
      const double slack_px = stride_cells * scene.grid.cell_m / distance_m * view.camera.focal_px();
      shows = pixel->x() > -slack_px && pixel->y() > -slack_px && pixel->x() < view.camera.width_px + slack_px &&
              pixel->y() < view.camera.height_px + slack_px;
    }
    if (shows) found.push_back(v);
  }
  return found;
}

// How far away something could stand that hides a cell of the area from one of the views [surface cells].
int occluder_reach(const OrthoScene& scene, const std::vector<std::size_t>& views, const WorldLattice& lattice,
                   const CellArea& area, const HeightRange& range) {
  double flattest = 0;  // largest run per rise
  for (const std::size_t v : views) {
    for (int corner = 0; corner < 4; ++corner) {
      const Eigen::Vector3d at =
          lattice.at(corner & 1 ? area.width : 0, corner & 2 ? area.height : 0, double(range.low_m));
      const Eigen::Vector3d up = scene.views[v].centre_in_world - at;
      flattest = std::max(flattest, up.z() > 0 ? std::min(std::hypot(up.x(), up.y()) / up.z(), 10.0) : 0.0);
    }
  }
  const double cell_m = scene.surface->grid.cell_m;
  const CellArea near = surface_area(scene, area, 0), far = surface_area(scene, area, kFarthestOccluder);
  constexpr int kBlock = HeightOverview::kBlock;
  int reach = 0;
  each_block(*scene.surface_overview, far, [&](int x, int y) {
    const int dx = std::max({0, near.column - (x + 1) * kBlock, x * kBlock - near.column - near.width});
    const int dy = std::max({0, near.row - (y + 1) * kBlock, y * kBlock - near.row - near.height});
    const int distance = std::max(dx, dy);
    const double casts = double(scene.surface_overview->highest_m.at(x, y) - range.low_m) * flattest / cell_m;
    if (distance < casts) reach = std::max(reach, std::min(distance + kBlock, int(casts) + 1));
  });
  return reach + 2;
}

FloatImage heights_of(const OrthoPatch& patch, const CellArea& area) {
  FloatImage heights_m(area.width, area.height);
  for (int y = 0; y < area.height; ++y) {
    const double v = patch.surface_y(patch.grid.north_of(area.row + y + 0.5));
    for (int x = 0; x < area.width; ++x)
      heights_m.at(x, y) = patch.surface.at(patch.surface_x(patch.grid.east_of(area.column + x + 0.5)), v);
  }
  return heights_m;
}

}  // namespace

std::vector<int> shrinks(const OrthoScene& scene, double cell_m) {
  std::vector<int> result;
  for (const View& view : scene.views) {
    const double pixel_m = std::abs(view.centre_in_map.z() - scene.surface_overview->mean_m) / view.camera.focal_px();
    int shrink = 1;
    while (shrink < 8 && 2 * shrink * pixel_m <= 1.05 * cell_m) shrink *= 2;
    result.push_back(shrink);
  }
  return result;
}

Result<std::optional<OrthoPatch>> make_patch(const OrthoScene& scene, const CellArea& area,
                                             std::vector<std::size_t>& views) {
  HeightRange range = heights_under(*scene.surface_overview, surface_area(scene, area, 1));
  if (range.empty()) return std::nullopt;
  OrthoPatch patch{scene.grid,
                   area.column,
                   area.row,
                   {},
                   WorldLattice(scene.frame, scene.grid, area.column, area.row, area.width, area.height,
                                double(range.low_m), double(range.high_m)),
                   {},
                   scene.surface->grid};
  views = views_over(scene, patch.lattice, area, range);
  if (views.empty()) return std::nullopt;
  const CellArea window = surface_area(scene, area, occluder_reach(scene, views, patch.lattice, area, range));
  if (window.width <= 0 || window.height <= 0) return std::nullopt;
  COLLINEA_TRY(FloatImage heights, scene.surface->read(window.column, window.row, window.width, window.height));
  FloatImage sigmas;
  if (scene.surface->read_sigma) {
    COLLINEA_TRY(sigmas, scene.surface->read_sigma(window.column, window.row, window.width, window.height));
  }
  patch.surface = HeightWindow(std::move(heights), window.column, window.row, scene.surface->grid.cell_m, sigmas);
  patch.heights_m = heights_of(patch, area);
  return patch;
}

}  // namespace collinea
