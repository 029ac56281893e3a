// SPDX-License-Identifier: Apache-2.0
#include "collinea/ortho/seam_plan.h"

#include <algorithm>

#include "collinea/base/parallel.h"
#include "collinea/ortho/seam_window.h"
#include "collinea/ortho/view_costs.h"

namespace collinea {
namespace {

constexpr int kWindow = 16 * SeamWindow::kBlock;  // cells of the plan
constexpr int kBlock = SeamWindow::kBlock;

int whole_blocks(int cells) { return (cells + kBlock - 1) / kBlock * kBlock; }

// Windows from `first` on, cut at the grid to whole blocks.
std::vector<CellArea> windows_of(const MapGrid& grid, int first) {
  std::vector<CellArea> windows;
  const int width = whole_blocks(grid.width), height = whole_blocks(grid.height);
  for (int row = first; row < height; row += kWindow) {
    for (int column = first; column < width; column += kWindow) {
      const int left = std::max(0, column), top = std::max(0, row);
      windows.push_back({left, top, std::min(column + kWindow, width) - left, std::min(row + kWindow, height) - top});
    }
  }
  return windows;
}

// A line between two of the first windows runs through it.
bool takes_up_a_border(const CellArea& window) {
  const auto inside = [](int first, int size) { return first / kWindow != (first + size - 1) / kWindow; };
  return inside(window.column, window.width) || inside(window.row, window.height);
}

class Planner {
 public:
  Planner(const OrthoScene& coarse, double cell_m, SeamPlan& plan, const Run& run)
      : coarse_(coarse), cell_m_(cell_m), plan_(plan), run_(run) {}

  // From nothing.
  Result<> plan(const CellArea& area) {
    std::vector<std::size_t> views;
    COLLINEA_TRY(const auto window, look_at(coarse_, cell_m_, area, views, run_));
    if (!window) return {};
    Raster<std::int16_t> labels = cheapest_views(*window);
    cut_seams(*window, 0, 0, area.width, area.height, labels);
    for (int y = 0; y < area.height; ++y)
      for (int x = 0; x < area.width; ++x)
        if (const std::int16_t label = labels.at(x, y); label != kNoView) set(area, x, y, views[std::size_t(label)]);
    return {};
  }

  // From the plan there is; the outermost cells stay, unless they are the border of the map.
  Result<> improve(const CellArea& area) {
    std::vector<std::size_t> views;
    COLLINEA_TRY(const auto window, look_at(coarse_, cell_m_, area, views, run_));
    if (!window) return {};
    Raster<std::int16_t> labels(area.width, area.height, 1, kNoView);
    for (int y = 0; y < area.height; ++y) {
      for (int x = 0; x < area.width; ++x) {
        const std::uint16_t source = get(area, x, y);
        const auto found = std::lower_bound(views.begin(), views.end(), std::size_t(source) - 1);
        if (source && found != views.end() && *found + 1 == source)
          labels.at(x, y) = std::int16_t(found - views.begin());
      }
    }
    const int right = area.column + area.width, bottom = area.row + area.height;
    cut_seams(*window, area.column > 0, area.row > 0, area.width - (right < coarse_.grid.width),
              area.height - (bottom < coarse_.grid.height), labels);
    for (int y = 0; y < area.height; ++y)
      for (int x = 0; x < area.width; ++x)
        if (const std::int16_t label = labels.at(x, y); label != kNoView) set(area, x, y, views[std::size_t(label)]);
    return {};
  }

 private:
  [[nodiscard]] std::uint16_t get(const CellArea& area, int x, int y) const {
    const int column = area.column + x, row = area.row + y;
    return column < plan_.source.width && row < plan_.source.height ? plan_.source.at(column, row) : std::uint16_t{0};
  }
  void set(const CellArea& area, int x, int y, std::size_t view) {
    const int column = area.column + x, row = area.row + y;
    if (column < plan_.source.width && row < plan_.source.height)
      plan_.source.at(column, row) = std::uint16_t(view + 1);
  }

  const OrthoScene& coarse_;
  const double cell_m_;  // of the orthophoto
  SeamPlan& plan_;
  const Run& run_;
};

Result<> in_windows(const std::vector<CellArea>& windows, const Run& run,
                    const std::function<Result<>(const CellArea&)>& work) {
  std::vector<Result<>> results(windows.size());
  parallel_for(run, windows.size(), [&](std::size_t i) { results[i] = work(windows[i]); });
  if (run.stopped()) return fail(Errc::kCancelled, "cancelled");
  for (auto& result : results)
    if (!result) return result;
  return {};
}

}  // namespace

SeamPlan::Part SeamPlan::part(const MapGrid& grid, const CellArea& area) const {
  Part result{Raster<std::uint16_t>(area.width, area.height), Raster<std::uint16_t>(area.width, area.height)};
  if (source.empty()) {
    fill(given, grid, area.column, area.row, result.source, result.below);
    return result;
  }
  for (int y = std::max(0, -area.row); y < area.height && (area.row + y) / kCoarse < source.height; ++y)
    for (int x = std::max(0, -area.column); x < area.width && (area.column + x) / kCoarse < source.width; ++x)
      result.source.at(x, y) = source.at((area.column + x) / kCoarse, (area.row + y) / kCoarse);
  return result;
}

MapGrid plan_grid(const MapGrid& orthophoto) {
  MapGrid grid = orthophoto;
  grid.cell_m *= SeamPlan::kCoarse;
  grid.width = (orthophoto.width + SeamPlan::kCoarse - 1) / SeamPlan::kCoarse;
  grid.height = (orthophoto.height + SeamPlan::kCoarse - 1) / SeamPlan::kCoarse;
  return grid;
}

Result<SeamPlan> plan_seams(const OrthoScene& scene, const std::vector<int>& shrink, const Run& run) {
  OrthoScene coarse = scene;
  coarse.grid = plan_grid(scene.grid);
  coarse.shrink = shrink;
  SeamPlan plan{Raster<std::uint16_t>(coarse.grid.width, coarse.grid.height), {}};
  Planner planner(coarse, scene.grid.cell_m, plan, run);
  const auto first = windows_of(coarse.grid, 0);
  auto second = windows_of(coarse.grid, -kWindow / 2);
  std::erase_if(second, [](const CellArea& window) { return !takes_up_a_border(window); });
  const auto planned = in_windows(first, run, [&](const CellArea& area) { return planner.plan(area); });
  if (!planned) return tl::unexpected(planned.error());
  run.report("ortho: seams", 0.5);
  const auto improved = in_windows(second, run, [&](const CellArea& area) { return planner.improve(area); });
  if (!improved) return tl::unexpected(improved.error());
  // Narrower than the zone in which pictures are mixed: no seam is worth that, and what its view alone sees is taken
  // from it anyway.
  constexpr std::size_t kFewest = 16;
  absorb_small_areas(kFewest, plan.source);
  run.report("ortho: seams", 1);
  return plan;
}

}  // namespace collinea
