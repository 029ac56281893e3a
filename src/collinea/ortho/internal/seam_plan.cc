// SPDX-License-Identifier: Apache-2.0
#include "collinea/ortho/internal/seam_plan.h"

#include <algorithm>
#include <functional>

#include "collinea/base/units.h"
#include "collinea/ortho/internal/seam_window.h"
#include "collinea/ortho/internal/view_costs.h"

namespace collinea {
namespace {

constexpr int kWindow = 16 * SeamWindow::kBlock;  // cells of the plan
constexpr int kBlock = SeamWindow::kBlock;

int whole_blocks(int cells) { return (cells + kBlock - 1) / kBlock * kBlock; }

// Windows from a cell on, cut at the grid to whole blocks.
std::vector<CellArea> windows_of(const MapGrid& grid, int first_column, int first_row) {
  std::vector<CellArea> windows;
  const int width = whole_blocks(grid.width), height = whole_blocks(grid.height);
  for (int row = first_row; row < height; row += kWindow) {
    for (int column = first_column; column < width; column += kWindow) {
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

MapGrid coarser(MapGrid grid, int times) {
  grid.cell_m *= times;
  grid.width = (grid.width + times - 1) / times;
  grid.height = (grid.height + times - 1) / times;
  return grid;
}

// Settles the views of windows of a grid.
class Planner {
 public:
  Planner(const OrthoScene& scene, const SeamLook& look, Raster<std::uint16_t>& source, const Run& run)
      : scene_(scene), look_(look), source_(source), run_(run) {}

  // From nothing.
  Result<> plan(const CellArea& area) {
    return settle(area, false, [](int, int) { return std::uint16_t{0}; });
  }

  // From the views there are. The outermost cells stay, unless they are the border of the map.
  Result<> improve(const CellArea& area) {
    return settle(area, true, [&](int column, int row) {
      return column < source_.width && row < source_.height ? source_.at(column, row) : std::uint16_t{0};
    });
  }

  // From a plan of larger cells (SeamLook), whose views the outermost cells keep: so windows side by side fit.
  Result<> refine(const CellArea& area) {
    return settle(area, true, [&](int column, int row) { return look_.started(column, row); });
  }

 private:
  template <class Started>
  Result<> settle(const CellArea& area, bool outermost_stay, const Started& started) {
    std::vector<std::size_t> views;
    COLLINEA_TRY(const auto window, look_at(scene_, look_, area, views, run_));
    if (!window) return {};
    Raster<std::int16_t> labels = cheapest_views(*window);
    for (int y = 0; y < area.height; ++y) {
      for (int x = 0; x < area.width; ++x) {
        const std::int16_t view = index_of_source(views, started(area.column + x, area.row + y));
        if (view == kNoView) continue;
        const auto* choice = window->choice(x, y, view);
        if (choice && choice->price != SeamWindow::kForbidden) labels.at(x, y) = view;
      }
    }
    const int right = area.column + area.width, bottom = area.row + area.height;
    cut_seams(*window, outermost_stay && area.column > 0, outermost_stay && area.row > 0,
              area.width - (outermost_stay && right < scene_.grid.width),
              area.height - (outermost_stay && bottom < scene_.grid.height), labels);
    for (int y = 0; y < area.height && area.row + y < source_.height; ++y)
      for (int x = 0; x < area.width && area.column + x < source_.width; ++x)
        if (const std::int16_t label = labels.at(x, y); label != kNoView)
          source_.at(area.column + x, area.row + y) = std::uint16_t(views[std::size_t(label)] + 1);
    return {};
  }

  const OrthoScene& scene_;
  const SeamLook& look_;
  Raster<std::uint16_t>& source_;
  const Run& run_;
};

// Share of some windows in the progress of all, those of the draft and of the plan.
struct Share {
  double begin, end;
};

Result<> in_windows(const std::vector<CellArea>& windows, Share share, const Run& run,
                    const std::function<Result<>(const CellArea&)>& work) {
  UnitList list{.stage = "ortho: seams", .begin = share.begin, .end = share.end};
  for (const CellArea& window : windows) list.units.push_back(Unit::window(window.column, window.row));
  const auto one = [&](std::size_t i, const Run&) { return work(windows[i]).map([] { return UnitWorked{}; }); };
  COLLINEA_TRY(run_units(run, list, {.work = one}));
  return {};
}

}  // namespace

SeamPlan::Part SeamPlan::part(const MapGrid& grid, const CellArea& area) const {
  Part result{Raster<std::uint16_t>(area.width, area.height), Raster<std::uint16_t>(area.width, area.height)};
  if (source.empty()) {
    fill(given, grid, area.column, area.row, result.source, result.below);
    fill(patches, grid, area.column, area.row, result.source, result.below);
    return result;
  }
  for (int y = std::max(0, -area.row); y < area.height && (area.row + y) / kCoarse < source.height; ++y)
    for (int x = std::max(0, -area.column); x < area.width && (area.column + x) / kCoarse < source.width; ++x)
      result.source.at(x, y) = source.at((area.column + x) / kCoarse, (area.row + y) / kCoarse);
  fill(patches, grid, area.column, area.row, result.source, result.below);
  return result;
}

MapGrid plan_grid(const MapGrid& orthophoto) { return coarser(orthophoto, SeamPlan::kCoarse); }

namespace {

// The scene on a grid of its own.
OrthoScene on_grid(const OrthoScene& scene, const MapGrid& grid) {
  OrthoScene result = scene;
  result.grid = grid;
  result.shrink = shrinks(scene, grid.cell_m);
  return result;
}

// Narrow windows along the borders of those that lie side by side: upright ones, or level ones.
std::vector<CellArea> windows_on_borders(const MapGrid& grid, bool upright) {
  constexpr int kLong = 4 * kBlock;
  std::vector<CellArea> windows;
  const int width = whole_blocks(grid.width), height = whole_blocks(grid.height);
  const int across = upright ? width : height, along = upright ? height : width;
  for (int border = kWindow; border < across; border += kWindow) {
    for (int begin = -kLong / 2; begin < along; begin += kLong) {
      const int from = border - kBlock, thick = std::min(2 * kBlock, across - from);
      const int first = std::max(0, begin), length = std::min(begin + kLong, along) - first;
      windows.push_back(upright ? CellArea{from, first, thick, length} : CellArea{first, from, length, thick});
    }
  }
  return windows;
}

bool has_a_seam(const Raster<std::uint16_t>& source, const CellArea& area) {
  const int right = std::min(area.column + area.width, source.width),
            bottom = std::min(area.row + area.height, source.height);
  for (int y = area.row; y < bottom; ++y)
    for (int x = area.column; x < right; ++x)
      if (source.at(x, y) != source.at(area.column, area.row)) return true;
  return false;
}

// From nothing, in windows side by side; then in windows shifted by half their size in both directions and in each:
// what borders of windows have done to a seam is undone, also where those of two rounds meet.
Result<> plan_from_nothing(const OrthoScene& scene, const SeamLook& look, Raster<std::uint16_t>& source,
                           const Run& run) {
  Planner planner(scene, look, source, run);
  auto done = in_windows(windows_of(scene.grid, 0, 0), {0, 0.15}, run,
                         [&](const CellArea& area) { return planner.plan(area); });
  double begin = 0.15;
  constexpr int kHalf = kWindow / 2;
  for (const auto& [column, row] : {std::pair(-kHalf, -kHalf), std::pair(-kHalf, 0), std::pair(0, -kHalf)}) {
    auto windows = windows_of(scene.grid, column, row);
    std::erase_if(windows, [](const CellArea& window) { return !takes_up_a_border(window); });
    const Share share{begin, begin + 0.05};
    if (done) done = in_windows(windows, share, run, [&](const CellArea& area) { return planner.improve(area); });
    begin = share.end;
  }
  return done;
}

// A surface in the cells of a draft, which looks at it four times and more.
Result<HeightField> draft_surface(const HeightField& surface, int times, const std::filesystem::path& scratch,
                                  const Run& run) {
  HeightField coarse = thinned(surface, times);
  return scratch.empty() ? coarse : unpacked(coarse, scratch, run);
}

}  // namespace

Result<SeamPlan> plan_seams(const OrthoScene& scene, const Run& run) {
  constexpr int kOverview = 4;    // cells of the plan along one of the first draft
  constexpr double kRaised = 10;  // [surface cells]
  OrthoScene plan_scene = on_grid(scene, plan_grid(scene.grid));
  COLLINEA_TRY(const HeightField surface, draft_surface(*scene.surface, kOverview, scene.scratch, run));
  HeightField terrain;
  if (scene.terrain) {
    COLLINEA_TRY(terrain, draft_surface(*scene.terrain, kOverview, scene.scratch, run));
  }
  COLLINEA_TRY(const HeightOverview heights, overview(surface, run));
  OrthoScene draft_scene = on_grid(scene, coarser(plan_scene.grid, kOverview));
  draft_scene.surface = &surface, draft_scene.surface_overview = &heights;
  if (scene.terrain) draft_scene.terrain = &terrain;
  SeamLook look{scene.grid.cell_m, kRaised * scene.surface->grid.cell_m};
  Raster<std::uint16_t> draft(draft_scene.grid.width, draft_scene.grid.height);
  COLLINEA_TRY(plan_from_nothing(draft_scene, look, draft, run));
  look.start = &draft, look.start_times = kOverview, look.best_views = 3;
  SeamPlan plan{Raster<std::uint16_t>(plan_scene.grid.width, plan_scene.grid.height), {}};
  Planner planner(plan_scene, look, plan.source, run);
  auto refined = in_windows(windows_of(plan_scene.grid, 0, 0), {0.3, 0.8}, run,
                            [&](const CellArea& area) { return planner.refine(area); });
  // The draft's seams at the borders of these windows are not where those of the plan are: these close up.
  for (const bool upright : {true, false}) {
    auto windows = windows_on_borders(plan_scene.grid, upright);
    std::erase_if(windows, [&](const CellArea& window) { return !has_a_seam(plan.source, window); });
    const Share share = upright ? Share{0.8, 0.9} : Share{0.9, 1};
    if (refined) refined = in_windows(windows, share, run, [&](const CellArea& area) { return planner.improve(area); });
  }
  if (!refined) return tl::unexpected(std::move(refined).error());
  // Narrower than the zone in which images are mixed: no seam is worth that, and what its view alone sees is taken
  // from it anyway.
  constexpr std::size_t kFewest = 16;
  absorb_small_areas(kFewest, plan.source);
  return plan;
}

}  // namespace collinea
