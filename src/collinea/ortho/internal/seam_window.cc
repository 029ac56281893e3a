// SPDX-License-Identifier: Apache-2.0
#include "collinea/ortho/internal/seam_window.h"

#include <algorithm>
#include <cmath>

#include "collinea/ortho/internal/view_costs.h"

namespace collinea {
namespace {

constexpr int kBlock = SeamWindow::kBlock;
constexpr int kCells = kBlock * kBlock;

// The energy of a seam, per side of a cell. A raised thing is to be of one image as a whole: a seam along its
// outline, where surface and colours break anyway, is far cheaper than one across it. Where the surface steps, a break
// of colours does not show, and images that see past the step differ by it.
constexpr float kLength = 0.1f, kRaised = 6, kSteep = 0.5f, kDifferent = 1;
// The price of a view that is not the best for a cell, times the cells it is put in: a seam makes room for a raised
// thing of half the flying height. Both scale with the size of the image in pixels, so that the resolution does not
// matter.
constexpr double kDetour = 100;
// Showing a cell that only small things keep from the view: the first, and the second per (difference /
// kMostDifferent)^2 from the best view that sees it.
constexpr float kDoubtful = 0.2f, kBehindOtherThings = 4;
// Cells that are hidden from the view: they are taken from another one, which draws a seam on both sides of what is
// hidden. Across a raised thing, in a strip of six cells, that is 2 kRaised / 6 for each.
constexpr float kHiddenCell = kRaised / 3;
constexpr double kFullySteep = 3;  // [cells of the window] of height within 3 x 3 cells
constexpr int kMargin = kBlock;    // around the window, for what depends on surroundings

int price_of(float energy) { return int(energy * float(SeamWindow::kPrice) + 0.5f); }  // never negative

float grey_levels_between(const SeamWindow::Choice& a, const SeamWindow::Choice& b) {
  int sum = 0;
  for (std::size_t c = 0; c < 3; ++c) sum += std::abs(int(a.colour[c]) - int(b.colour[c]));
  return float(sum) / 3;
}

// How well the cells are seen by the views that are worth a look, without colours.
enum Sight : std::uint8_t { kHidden, kPastSmallThings, kSeen };

struct Looker {
  const SeamLook& how;
  const CellArea& area;
  const std::vector<std::size_t>& views;  // of the scene
  const OrthoPatch& patch;
  const CostLattice& lattice;
  Visibility& visibility;
  float per_cost;
  SeamWindow& window;
  std::vector<std::vector<Sight>> sights;  // [block][view * cell]

  // Those of the start in the block and half a block around it.
  void add_started(int i, int j, std::vector<std::int16_t>& worth_a_look) const {
    const int step = std::max(1, std::min(how.start_times, kBlock / 2));
    std::uint16_t last = 0;
    for (int y = -kBlock / 2; y < kBlock + kBlock / 2; y += step) {
      for (int x = -kBlock / 2; x < kBlock + kBlock / 2; x += step) {
        const std::uint16_t source = how.started(area.column + i * kBlock + x, area.row + j * kBlock + y);
        if (source == 0 || source == last) continue;
        last = source;
        const std::int16_t view = index_of_source(views, source);
        if (view == kNoView) continue;
        const auto found = std::lower_bound(worth_a_look.begin(), worth_a_look.end(), view);
        if (found == worth_a_look.end() || *found != view) worth_a_look.insert(found, view);
      }
    }
  }

  void look(int i, int j) {
    auto& block = window.block(i, j);
    const int bx = i + kMargin / kBlock, by = j + kMargin / kBlock;
    block.views = candidates_of(lattice, bx, by);
    if (how.start) add_started(i, j, block.views);
    block.choices.assign(block.views.size() * kCells, {});
    auto& sight = sights[std::size_t(j * window.blocks_across() + i)];
    sight.assign(block.choices.size(), kHidden);
    std::vector<float> costs(block.views.size());
    for (int cell = 0; cell < kCells; ++cell) {
      const int x = bx * kBlock + cell % kBlock, y = by * kBlock + cell / kBlock;
      if (std::isnan(patch.heights_m.at(x, y))) continue;
      costs_in_block(lattice, block.views, bx, by, cell % kBlock, cell / kBlock, costs.data());
      for (std::size_t k = 0; k < block.views.size(); ++k) {
        if (costs[k] >= kUseless) continue;
        const int view = block.views[k];
        Sight& seen = sight[k * kCells + std::size_t(cell)];
        seen = visibility.sees(view, x, y)                     ? kSeen
               : visibility.sees_past_small_things(view, x, y) ? kPastSmallThings
                                                               : kHidden;
        block.choices[k * kCells + std::size_t(cell)].price = price_of(per_cost * costs[k]);
      }
    }
  }
};

void colour_block(const OrthoPatch& patch, const OrthoScene& coarse, std::size_t v, const ColourImage& image, int left,
                  int top, SeamWindow::Choice* choices) {
  const View& view = coarse.views[v];
  for (int cell = 0; cell < kCells; ++cell) {
    const int x = left + cell % kBlock, y = top + cell / kBlock;
    if (std::isnan(patch.heights_m.at(x, y))) continue;
    const Eigen::Vector3d position = patch.world_at(x, y);
    const auto pixel = pixel_of(view, position);
    if (!pixel || !shows(view, *pixel)) continue;
    SeamWindow::Choice& choice = choices[cell];
    choice.has_colour = true;
    const std::array<float, 3> factor = coarse.balance.factor(v, view, position, *pixel);
    for (int c = 0; c < 3; ++c)
      choice.colour[std::size_t(c)] = std::uint8_t(
          std::clamp(factor[std::size_t(c)] * bilinear(image, pixel->x() * image.width / view.camera.width_px,
                                                       pixel->y() * image.height / view.camera.height_px, c),
                     0.0f, 255.0f));
  }
}

Result<> colour(const OrthoScene& coarse, const OrthoPatch& patch, const std::vector<std::size_t>& views,
                SeamWindow& window, const Run& run) {
  for (std::size_t v = 0; v < views.size(); ++v) {
    if (run.stopped()) return fail(Errc::kCancelled, "cancelled");
    std::shared_ptr<const ColourImage> image;
    for (int j = 0; j < window.blocks_down(); ++j) {
      for (int i = 0; i < window.blocks_across(); ++i) {
        auto& block = window.block(i, j);
        const int slot = block.slot_of(std::int16_t(v));
        if (slot < 0) continue;
        if (!image) {
          COLLINEA_TRY(image, coarse.images->image_of(coarse.views[views[v]].image, coarse.shrink[views[v]]));
        }
        colour_block(patch, coarse, views[v], *image, kMargin + i * kBlock, kMargin + j * kBlock,
                     block.choices.data() + slot * kCells);
      }
    }
  }
  return {};
}

// Makes views pay in cells that they do not show well. What small things keep from them costs the more, the less it
// looks like what the best view that sees the cell shows: twigs among leaves do no harm, a chimney on a roof does. What
// is hidden is going to be taken from another view, cell by cell; what is not on the image cannot be had.
void price_doubts(const std::vector<Sight>& sight, float per_cell, SeamWindow::Block& block) {
  for (std::size_t cell = 0; cell < kCells; ++cell) {
    const SeamWindow::Choice* best = nullptr;
    for (std::size_t k = 0; k < block.views.size(); ++k) {
      const auto& choice = block.choices[k * kCells + cell];
      if (sight[k * kCells + cell] == kSeen && choice.has_colour && (!best || choice.price < best->price))
        best = &choice;
    }
    for (std::size_t k = 0; k < block.views.size(); ++k) {
      auto& choice = block.choices[k * kCells + cell];
      if (choice.price == SeamWindow::kForbidden || sight[k * kCells + cell] == kSeen) continue;
      if (!choice.has_colour) {
        choice.price = SeamWindow::kForbidden;
        continue;
      }
      if (sight[k * kCells + cell] == kHidden) {
        choice.price += price_of(per_cell * kHiddenCell);
        continue;
      }
      const float apart = best ? grey_levels_between(choice, *best) / float(SeamWindow::kMostDifferent) : 1.0f;
      choice.price += price_of(per_cell * (kDoubtful + kBehindOtherThings * apart * apart));
    }
  }
}

Result<FloatImage> terrain_under(const OrthoScene& coarse, const OrthoPatch& patch, const SeamWindow& window) {
  FloatImage result(window.width(), window.height(), 1, std::numeric_limits<float>::quiet_NaN());
  const MapGrid &grid = coarse.grid, &from = coarse.terrain->grid;
  const auto column_of = [&](int x) { return from.column_of(grid.east_of(patch.column + kMargin + x + 0.5)); };
  const auto row_of = [&](int y) { return from.row_of(grid.north_of(patch.row + kMargin + y + 0.5)); };
  const int left = std::clamp(int(std::floor(column_of(0))), 0, from.width);
  const int right = std::clamp(int(std::floor(column_of(window.width() - 1))) + 1, 0, from.width);
  if (right <= left) return result;
  // In strips: cells of a draft may be many times as large as those of the terrain.
  constexpr double kMostCells = 1 << 22;
  const double rows_below = std::max(1.0, grid.cell_m / from.cell_m);
  const int strip = int(std::clamp(kMostCells / (double(right - left) * rows_below), 1.0, double(result.height)));
  for (int first = 0; first < result.height; first += strip) {
    const int last = std::min(first + strip, result.height) - 1;
    const int top = std::clamp(int(std::floor(row_of(first))), 0, from.height);
    const int bottom = std::clamp(int(std::floor(row_of(last))) + 1, 0, from.height);
    if (bottom <= top) continue;
    COLLINEA_TRY(const FloatImage heights, coarse.terrain->read(left, top, right - left, bottom - top));
    for (int y = first; y <= last; ++y) {
      for (int x = 0; x < result.width; ++x) {
        const int column = int(std::floor(column_of(x))) - left, row = int(std::floor(row_of(y))) - top;
        if (column >= 0 && row >= 0 && column < heights.width && row < heights.height)
          result.at(x, y) = heights.at(column, row);
      }
    }
  }
  return result;
}

FloatImage steepness_of(const OrthoScene& coarse, const OrthoPatch& patch, const SeamWindow& window) {
  FloatImage steep(window.width(), window.height());
  const double steep_m = kFullySteep * coarse.grid.cell_m;
  for (int y = 0; y < steep.height; ++y) {
    for (int x = 0; x < steep.width; ++x) {
      float low = std::numeric_limits<float>::infinity(), high = -low;
      for (int v = y - 1; v <= y + 1; ++v)
        for (int u = x - 1; u <= x + 1; ++u)
          if (const float z = patch.heights_m.at(kMargin + u, kMargin + v); !std::isnan(z))
            low = std::min(low, z), high = std::max(high, z);
      if (high > low) steep.at(x, y) = float(std::min(double(high - low) / steep_m, 1.0));
    }
  }
  return steep;
}

Result<FloatImage> raisedness_of(const OrthoScene& coarse, double raised_m, const OrthoPatch& patch,
                                 const SeamWindow& window) {
  FloatImage raised(window.width(), window.height());
  if (!coarse.terrain) return raised;
  COLLINEA_TRY(const FloatImage terrain_m, terrain_under(coarse, patch, window));
  for (int y = 0; y < raised.height; ++y)
    for (int x = 0; x < raised.width; ++x)
      if (const float above_m = patch.heights_m.at(kMargin + x, kMargin + y) - terrain_m.at(x, y); above_m > 0)
        raised.at(x, y) = float(std::min(double(above_m) / raised_m, 1.0));
  return raised;
}

}  // namespace

SeamWindow::SeamWindow(int blocks_across, int blocks_down)
    : across_(blocks_across), down_(blocks_down), blocks_(std::size_t(blocks_across * blocks_down)) {}

int SeamWindow::Block::slot_of(std::int16_t view) const {
  const auto found = std::lower_bound(views.begin(), views.end(), view);
  return found != views.end() && *found == view ? int(found - views.begin()) : -1;
}

const SeamWindow::Choice* SeamWindow::choice(int x, int y, std::int16_t view) const {
  const Block& at = block(x / kBlock, y / kBlock);
  const int slot = at.slot_of(view);
  return slot < 0 ? nullptr : &at.choices[std::size_t(slot * kCells + y % kBlock * kBlock + x % kBlock)];
}

float SeamWindow::difference(const Choice* a, const Choice* b) {
  return a && b && a->has_colour && b->has_colour
             ? std::min(1.0f, grey_levels_between(*a, *b) / float(SeamWindow::kMostDifferent))
             : 1.0f;
}

int SeamWindow::seam_price(int x, int y, int u, int v, float different) const {
  const float step = std::max(steep.at(x, y), steep.at(u, v));
  return price_of(kLength + kRaised * std::min(raised.at(x, y), raised.at(u, v)) + kSteep * step +
                  kDifferent * (1 - step) * different);
}

std::int16_t index_of_source(const std::vector<std::size_t>& views, std::uint16_t source) {
  if (source == 0) return kNoView;
  const auto found = std::lower_bound(views.begin(), views.end(), std::size_t(source) - 1);
  return found != views.end() && *found + 1 == source ? std::int16_t(found - views.begin()) : kNoView;
}

Result<std::optional<SeamWindow>> look_at(const OrthoScene& coarse, const SeamLook& look, const CellArea& area,
                                          std::vector<std::size_t>& views, const Run& run) {
  const CellArea with_margin{area.column - kMargin, area.row - kMargin, area.width + 2 * kMargin,
                             area.height + 2 * kMargin};
  COLLINEA_TRY(const std::optional<OrthoPatch> patch, make_patch(coarse, with_margin, views));
  if (!patch) return std::nullopt;
  std::vector<const View*> looking;
  double height_m = 0;
  for (const std::size_t v : views) looking.push_back(&coarse.views[v]);
  for (const View& view : coarse.views) height_m += view.centre_in_map.z() - coarse.surface_overview->mean_m;
  height_m = std::max(height_m / double(coarse.views.size()), coarse.grid.cell_m);
  const int edge_cells = int(std::ceil(rim_m(*coarse.surface, look.cell_m) / coarse.grid.cell_m));
  Visibility visibility(*patch, looking, edge_cells);
  const CostLattice lattice = costs_at_nodes(*patch, looking, look.cell_m, look.best_views);
  SeamWindow window(area.width / kBlock, area.height / kBlock);
  Looker looker{look,   area, views, *patch, lattice, visibility, float(kDetour * coarse.grid.cell_m / height_m),
                window, {}};
  looker.sights.resize(std::size_t(window.blocks_across() * window.blocks_down()));
  for (int j = 0; j < window.blocks_down(); ++j)
    for (int i = 0; i < window.blocks_across(); ++i) looker.look(i, j);
  COLLINEA_TRY(colour(coarse, *patch, views, window, run));
  const auto per_cell = float(coarse.grid.cell_m / (SeamWindow::kCoarse * look.cell_m));
  for (int j = 0; j < window.blocks_down(); ++j)
    for (int i = 0; i < window.blocks_across(); ++i)
      price_doubts(looker.sights[std::size_t(j * window.blocks_across() + i)], per_cell, window.block(i, j));
  window.steep = steepness_of(coarse, *patch, window);
  COLLINEA_TRY(window.raised, raisedness_of(coarse, look.raised_m, *patch, window));
  return window;
}

}  // namespace collinea
