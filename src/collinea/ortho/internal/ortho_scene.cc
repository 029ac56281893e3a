// SPDX-License-Identifier: Apache-2.0
#include "collinea/ortho/internal/ortho_scene.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace collinea {
namespace {

constexpr int kFarthestOccluder = 4096;  // [surface cells]
constexpr int kBlock = HeightOverview::kBlock;

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

// Views that show something of the patch, by a coarse look at 5 x 5 positions, lowest and highest.
std::vector<std::size_t> views_over(const OrthoScene& scene, const WorldLattice& lattice, const CellArea& area,
                                    const HeightRange& range) {
  std::vector<std::size_t> found;
  const double stride_cells = std::max(area.width, area.height) / 4.0;
  for (std::size_t v = 0; v < scene.views.size(); ++v) {
    const View& view = scene.views[v];
    bool shows = false;
    for (int sample = 0; sample < 50 && !shows; ++sample) {
      const double x = area.width * (sample % 5) / 4.0, y = area.height * (sample / 5 % 5) / 4.0;
      const Eigen::Vector3d at = lattice.at(x, y, double(sample < 25 ? range.low_m : range.high_m));
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

// From the lowest points of an area to the views that show it, in cells of the surface.
struct LinesOfSight {
  double cells_per_m = 0;  // the flattest: how far it runs per rise
  double cells = 0;        // the longest
  double least_rise_m = std::numeric_limits<double>::infinity();

  // The flattest from points so much higher.
  [[nodiscard]] double cells_per_m_from(double lifted_m) const {
    return cells_per_m * least_rise_m / std::max(least_rise_m - lifted_m, 1e-3 * least_rise_m);
  }
};

LinesOfSight lines_of_sight(const OrthoScene& scene, const std::vector<std::size_t>& views, const WorldLattice& lattice,
                            const CellArea& area, const HeightRange& range) {
  constexpr double kFlattest = 10;
  const double cell_m = scene.surface->grid.cell_m;
  LinesOfSight lines;
  for (const std::size_t v : views) {
    const View& view = scene.views[v];
    double to_corner = 0, rise_m = 0;
    for (int corner = 0; corner < 4; ++corner) {
      const Eigen::Vector3d at =
          lattice.at(corner & 1 ? area.width : 0, corner & 2 ? area.height : 0, double(range.low_m));
      const Eigen::Vector3d up = view.centre_in_world - at;
      if (!(up.z() > 0)) continue;
      to_corner = std::max(to_corner, std::hypot(up.x(), up.y()) / up.z());
      rise_m = std::max(rise_m, up.z());
      lines.least_rise_m = std::min(lines.least_rise_m, up.z());
    }
    const double run_per_rise = std::min({to_corner, view.most_run_per_rise, kFlattest});
    lines.cells_per_m = std::max(lines.cells_per_m, run_per_rise / cell_m);
    lines.cells = std::max(lines.cells, run_per_rise * rise_m / cell_m);
  }
  return lines;
}

int gap(int first, int cells, int other_first, int other_cells) {
  return std::max({0, other_first - first - cells, first - other_first - other_cells});
}

// What could hide points of an area, by the highest and lowest of blocks of the surface.
struct Reach {
  int cells = 0;           // from the area on: how far away something could stand that does
  SurfaceBlocks far = {};  // empty: nothing that does is further than Occluders::kNear from what it hides
};

// The lowest of the surface under parts of an area.
struct LowPart {
  CellArea cells;
  float low_m;
};

std::vector<LowPart> low_parts(const HeightOverview& overview, const CellArea& under) {
  constexpr int kPart = 4 * kBlock;
  std::vector<LowPart> parts;
  for (int row = under.row / kPart * kPart; row < under.row + under.height; row += kPart) {
    for (int column = under.column / kPart * kPart; column < under.column + under.width; column += kPart) {
      const int left = std::max(column, under.column), top = std::max(row, under.row);
      const CellArea part{left, top, std::min(column + kPart, under.column + under.width) - left,
                          std::min(row + kPart, under.row + under.height) - top};
      if (const HeightRange range = heights_under(overview, part); !range.empty()) parts.push_back({part, range.low_m});
    }
  }
  return parts;
}

// The blocks around that may hide a point of the area from farther than what is looked at in full.
SurfaceBlocks far_blocks(const HeightOverview& overview, const LinesOfSight& lines, const CellArea& under,
                         const CellArea& around, float low_m) {
  const std::vector<LowPart> parts = low_parts(overview, under);
  const int left = around.column / kBlock, top = around.row / kBlock;
  SurfaceBlocks far{left, top,
                    Raster<std::uint8_t>((around.column + around.width - 1) / kBlock - left + 1,
                                         (around.row + around.height - 1) / kBlock - top + 1)};
  bool any = false;
  each_block(overview, around, [&](int x, int y) {
    const float high_m = overview.highest_m.at(x, y);
    for (const LowPart& part : parts) {
      const double casts = std::min(double(high_m - low_m) * lines.cells_per_m,
                                    double(high_m - part.low_m) * lines.cells_per_m_from(double(part.low_m - low_m)));
      if (casts < Occluders::kNear) continue;
      const CellArea& from = part.cells;
      const double across = gap(from.column, from.width, x * kBlock, kBlock),
                   down = gap(from.row, from.height, y * kBlock, kBlock);
      if (std::hypot(across, down) > casts + kBesides) continue;
      // Whether the farthest corners are further apart than what is looked at in full.
      if (std::hypot(across + from.width + kBlock, down + from.height + kBlock) < Occluders::kNear) continue;
      far.wanted.at(x - left, y - top) = 1;
      any = true;
      return;
    }
  });
  return any ? far : SurfaceBlocks{};
}

Reach reach_of(const OrthoScene& scene, const LinesOfSight& lines, const CellArea& area, const HeightRange& range) {
  const HeightOverview& overview = *scene.surface_overview;
  const int most = int(std::min(lines.cells, double(kFarthestOccluder))) + 1;
  const CellArea under = surface_area(scene, area, 0), around = surface_area(scene, area, most);
  Reach reach;
  float highest_m = range.low_m;
  each_block(overview, around, [&](int x, int y) {
    const int distance =
        std::max(gap(under.column, under.width, x * kBlock, kBlock), gap(under.row, under.height, y * kBlock, kBlock));
    const double casts = double(overview.highest_m.at(x, y) - range.low_m) * lines.cells_per_m;
    if (distance >= casts) return;
    reach.cells = std::max(reach.cells, std::min(distance + kBlock, int(casts) + 1));
    highest_m = std::max(highest_m, overview.highest_m.at(x, y));
  });
  if (double(highest_m - range.low_m) * lines.cells_per_m >= Occluders::kNear)
    reach.far = far_blocks(overview, lines, under, around, range.low_m);
  return reach;
}

FloatImage heights_of(const OrthoScene& scene, const CellArea& area, const FloatImage& surface_m,
                      const CellArea& window) {
  const MapGrid &grid = scene.grid, &from = scene.surface->grid;
  FloatImage heights_m(area.width, area.height);
  for (int y = 0; y < area.height; ++y) {
    const double v = from.row_of(grid.north_of(area.row + y + 0.5)) - window.row;
    for (int x = 0; x < area.width; ++x)
      heights_m.at(x, y) =
          height_at(surface_m, from.column_of(grid.east_of(area.column + x + 0.5)) - window.column, v, from.cell_m);
  }
  return heights_m;
}

// The window in full: to whole ceilings.
CellArea near_window(const OrthoScene& scene, const CellArea& area, const Reach& reach) {
  constexpr int kWhole = Occluders::kCeilingReach;
  const int margin = reach.far.wanted.empty() ? std::min(reach.cells, Occluders::kNear) : Occluders::kNear;
  const CellArea asked = surface_area(scene, area, margin + kBesides);
  const auto end = [](int first, int cells, int most) {
    return std::min((first + cells + kWhole - 1) / kWhole * kWhole, most);
  };
  const int left = asked.column / kWhole * kWhole, top = asked.row / kWhole * kWhole;
  return {left, top, end(asked.column, asked.width, scene.surface->grid.width) - left,
          end(asked.row, asked.height, scene.surface->grid.height) - top};
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
  const Reach reach = reach_of(scene, lines_of_sight(scene, views, patch.lattice, area, range), area, range);
  const CellArea window = near_window(scene, area, reach);
  if (window.width <= 0 || window.height <= 0) return std::nullopt;
  COLLINEA_TRY(FloatImage heights, scene.surface->read(window.column, window.row, window.width, window.height));
  patch.heights_m = heights_of(scene, area, heights, window);
  COLLINEA_TRY(patch.occluders, occluders_of(*scene.surface, std::move(heights), window, reach.far));
  return patch;
}

}  // namespace collinea
