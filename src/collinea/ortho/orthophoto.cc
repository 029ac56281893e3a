// SPDX-License-Identifier: Apache-2.0
#include "collinea/ortho/orthophoto.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "collinea/base/memory.h"
#include "collinea/base/units.h"
#include "collinea/ortho/internal/seam_plan.h"
#include "collinea/surface/dsm.h"

namespace collinea {
namespace {

constexpr std::size_t kImageMemory = std::size_t{512} << 20;
// Two images at least, between which a seam may run: else they would be decoded again for each tile of it.
std::size_t image_memory(const OrthoScene& scene) {
  std::size_t most = kImageMemory;
  for (std::size_t v = 0; v < scene.views.size(); ++v) {
    const Camera& camera = scene.views[v].camera;
    const std::size_t shrink = std::size_t(scene.shrink[v]);
    most = std::max(most,
                    2 * 3 * (std::size_t(camera.width_px) / shrink + 1) * (std::size_t(camera.height_px) / shrink + 1));
  }
  return most;
}

// Those that two tiles in work side by side take their cells from. Of 400 images of a megapixel, 64 in place of these
// 24 spared one per cent of the time; of images so large that fewer fill the memory above, there is no use for more.
std::size_t most_images(const Run& run) { return 8 + 8 * std::size_t(std::max(1, run.threads)); }
constexpr double kMostCells = 4e10;
constexpr std::size_t kMostPoints = 40'000;

// The grid of the orthophoto covers the surface model; its cell edges lie on multiples of the cell size.
Result<MapGrid> grid_over(const MapGrid& surface, double cell_m) {
  MapGrid grid = surface;
  grid.cell_m = cell_m;
  constexpr double kRounding = 1e-6;  // cells that only rounding would add
  const double west = std::floor(surface.west_m / cell_m + kRounding),
               north = std::ceil(surface.north_m / cell_m - kRounding);
  const double east = std::ceil(surface.east_of(surface.width) / cell_m - kRounding);
  const double south = std::floor(surface.north_of(surface.height) / cell_m + kRounding);
  if ((east - west) * (north - south) > kMostCells || east - west > 1e6 || north - south > 1e6)
    return fail(Errc::kBadInput, "the orthophoto would have " + std::to_string(std::int64_t(east - west)) + " x " +
                                     std::to_string(std::int64_t(north - south)) + " cells: choose a larger cell_m");
  grid.west_m = west * cell_m, grid.north_m = north * cell_m;
  grid.width = int(east - west), grid.height = int(north - south);
  return grid;
}

std::vector<Eigen::Vector3d> positions_in_world(const HeightOverview& overview, const MapGrid& grid,
                                                const LocalFrame* frame) {
  std::vector<Eigen::Vector3d> positions;
  const std::size_t stride = (overview.samples.size() + kMostPoints - 1) / kMostPoints;
  for (std::size_t i = 0; i < overview.samples.size(); i += stride) {
    const SurfaceSample& sample = overview.samples[i];
    positions.emplace_back(grid.east_of(sample.column), grid.north_of(sample.row), double(sample.height_m));
  }
  if (frame) frame->local_from_map(positions);
  return positions;
}

void add(const OrthoTally& tally, OrthoSummary& summary, std::set<std::uint16_t>& used, SeamAgreement& seams) {
  seams.add(tally.seams);
  for (const auto& [view, cells] : tally.not_followed) summary.not_followed[view] += cells;
  summary.painted_cells += tally.painted_cells;
  summary.empty_cells += tally.empty_cells;
  used.insert(tally.used.begin(), tally.used.end());
}

void sum_up(const SeamAgreement& seams, OrthoSummary& summary) {
  if (seams.sides == 0) return;
  summary.seam_length_m = double(seams.sides) * summary.grid.cell_m;
  summary.seam_difference_grey = seams.difference_grey / double(seams.sides);
  double squares = 0;
  for (const auto& [views, step] : seams.steps) squares += step.grey_levels * step.grey_levels / double(step.sides);
  summary.seam_step_grey = std::sqrt(squares / double(seams.sides));
}

CellArea area_of(const Unit& tile, const MapGrid& grid) {
  const int column = int(tile.first) * kOrthoTile, row = int(tile.second) * kOrthoTile;
  return {column, row, std::min(kOrthoTile, grid.width - column), std::min(kOrthoTile, grid.height - row)};
}

// Tiles are made side by side, and handed on in their order.
Result<> make_tiles(const OrthoScene& scene, const SeamGuides& guides, const OrthoSink& sink, OrthoSummary& summary,
                    const Run& run) {
  const MapGrid& grid = scene.grid;
  const UnitList list{"ortho", tiles_over(grid.width, grid.height, kOrthoTile, kOrthoTile)};
  std::vector<SeamPolygon> changed;
  if (guides.earlier) changed = changed_patches(guides.earlier->kept.patches, guides.patches);
  std::set<std::uint16_t> used;
  SeamAgreement seams;
  const auto is_kept = [&](const CellArea& area) {
    return guides.earlier &&
           std::ranges::none_of(changed, [&](const auto& patch) { return reaches(patch, grid, area); });
  };
  const auto make = [&](const Unit& unit) {
    const CellArea area = area_of(unit, grid);
    if (is_kept(area)) return guides.earlier->read(area);
    return make_ortho_tile(scene, area.column, area.row, area.width, area.height, run);
  };
  const auto take = [&](const Unit& unit, const OrthoTile& tile) {
    const bool kept = is_kept(area_of(unit, grid));
    summary.kept.tallies.push_back(kept ? guides.earlier->kept.tallies[summary.kept.tallies.size()] : tally_of(tile));
    summary.kept_tiles += kept;
    add(summary.kept.tallies.back(), summary, used, seams);
    auto taken = sink.take(int(unit.first) * kOrthoTile, int(unit.second) * kOrthoTile, tile);
    give_back_freed_memory();
    return taken;
  };
  COLLINEA_TRY(run_units_in_order(run, list, make, take));
  summary.images_used = used.size();
  sum_up(seams, summary);
  return {};
}

// Whether an orthophoto of this grid and these views can have left it.
bool fits(const KeptOrthophoto& kept, const OrthoScene& scene, bool is_given) {
  const MapGrid plan = is_given ? MapGrid{} : plan_grid(scene.grid);
  return kept.tallies.size() == tiles_over(scene.grid.width, scene.grid.height, kOrthoTile, kOrthoTile).size() &&
         kept.plan.width == plan.width && kept.plan.height == plan.height && raster_of(kept.plan) &&
         kept.balance.exposures.size() == scene.views.size();
}

}  // namespace

Result<OrthoSummary> make_orthophoto(const Block& block, const LocalFrame* frame, const HeightField& surface,
                                     const SeamGuides& given, const PixelSource& pixels, double gsd_m,
                                     const OrthoSink& sink, const OrthoOptions& options, const Run& run) {
  COLLINEA_TRY(validate(options));
  SeamGuides guides = given;
  OrthoScene scene;
  scene.views = views_of(block, frame);
  if (guides.masks)
    for (View& view : scene.views) view.masks = guides.masks->of(view.image);
  if (scene.views.empty()) return fail(Errc::kIllPosed, "no oriented photographs for an orthophoto");
  if (scene.views.size() > 65'000) return fail(Errc::kUnsupported, "more than 65000 photographs for one orthophoto");
  if (!options.cell_m && !(gsd_m > 0 && std::isfinite(gsd_m)))
    return fail(Errc::kBadInput, "neither cell_m nor the ground size of a pixel is known");
  COLLINEA_TRY(scene.grid, grid_over(surface.grid, options.cell_m ? *options.cell_m : tidy_cell_m(gsd_m)));
  if (guides.earlier && !fits(guides.earlier->kept, scene, guides.given != nullptr)) guides.earlier = nullptr;
  COLLINEA_TRY(const HeightOverview heights, overview(surface, run));
  scene.surface = &surface, scene.surface_overview = &heights, scene.frame = frame;
  scene.terrain = guides.terrain, scene.scratch = sink.scratch;
  scene.shrink = shrinks(scene, scene.grid.cell_m);
  PixelCache images(pixels, image_memory(scene), most_images(run));
  scene.images = &images;
  scene.feather_cells = options.feather_cells;
  scene.balance.exposures.resize(scene.views.size());
  if (guides.earlier) {
    scene.balance = guides.earlier->kept.balance;
  } else if (options.balance) {
    COLLINEA_TRY(scene.balance, balance_of(scene.views, positions_in_world(heights, surface.grid, frame), pixels, run));
  }
  SeamPlan seams;
  if (guides.given) {
    seams.given = *guides.given;
  } else if (guides.earlier) {
    seams.source = raster_of(guides.earlier->kept.plan).value();
  } else {
    COLLINEA_TRY(seams, plan_seams(scene, run));
  }
  seams.patches = guides.patches;
  scene.seams = &seams;
  OrthoSummary summary;
  summary.grid = scene.grid;
  summary.kept = {scene.balance, runs_of(seams.source), guides.patches, {}};
  for (const View& view : scene.views) summary.sources.push_back(view.image);
  summary.seamlines = guides.given ? *guides.given : outlines_of(seams.source, plan_grid(scene.grid));
  summary.seamlines.insert(summary.seamlines.end(), guides.patches.begin(), guides.patches.end());
  COLLINEA_TRY(sink.begin(scene.grid));
  COLLINEA_TRY(make_tiles(scene, guides, sink, summary, run));
  return summary;
}

}  // namespace collinea
