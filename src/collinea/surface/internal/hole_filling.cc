// SPDX-License-Identifier: Apache-2.0
#include "collinea/surface/internal/hole_filling.h"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>
#include <vector>

namespace collinea {
namespace {

using Mask = Raster<std::uint8_t>;
using Distances = Raster<std::uint16_t>;
constexpr int kBlock = HoleFilling::kBlock;
constexpr std::uint16_t kFar = std::numeric_limits<std::uint16_t>::max() / 4;  // sums of two do not overflow

// What is lower hides no more than a few cells from the usual cameras: beside it there is no hole for that reason, and
// rough ground or leaves need not be followed down to their lowest points.
constexpr double kStepCells = 10;

// Half of 9 blocks: what is narrower and reaches out from the surface was no hole, but the shadow of something as
// broad.
constexpr int kRayReach = 4;

// Rows, columns, diagonals.
constexpr std::array<std::array<int, 2>, 4> kLines = {{{1, 0}, {0, 1}, {1, 1}, {-1, 1}}};

// Steps from each cell to the nearest set cell before it along (dx, dy), its own left out.
Distances steps_back(const Mask& mask, int dx, int dy) {
  Distances steps(mask.width, mask.height, 1, kFar);
  const int first_y = dy >= 0 ? 0 : mask.height - 1, step_y = dy >= 0 ? 1 : -1;
  const int first_x = dx >= 0 ? 0 : mask.width - 1, step_x = dx >= 0 ? 1 : -1;
  for (int y = first_y; y >= 0 && y < mask.height; y += step_y) {
    for (int x = first_x; x >= 0 && x < mask.width; x += step_x) {
      const int u = x - dx, v = y - dy;
      if (u < 0 || v < 0 || u >= mask.width || v >= mask.height) continue;
      steps.at(x, y) = mask.at(u, v) ? 1 : std::uint16_t(std::min<int>(steps.at(u, v) + 1, kFar));
    }
  }
  return steps;
}

// On how many of the four lines a cell lies between set cells with no more than `widest` others from one to the next.
Mask lines_between(const Mask& mask, int widest) {
  Mask count(mask.width, mask.height);
  for (const auto& [dx, dy] : kLines) {
    const Distances one = steps_back(mask, dx, dy), other = steps_back(mask, -dx, -dy);
    for (std::size_t i = 0; i < count.data.size(); ++i) count.data[i] += one.data[i] + other.data[i] - 1 <= widest;
  }
  return count;
}

// How many cells of the square of 2 r + 1 around each are set; outside there are none.
Distances set_around(const Mask& mask, int r) {
  Distances rows(mask.width, mask.height), result = rows;
  for (int y = 0; y < mask.height; ++y) {
    const auto cell = [&](int x) { return x >= 0 && x < mask.width ? mask.at(x, y) : std::uint8_t{0}; };
    int sum = 0;
    for (int x = -r; x < mask.width; ++x) {
      sum += cell(x + r) - cell(x - r - 1);
      if (x >= 0) rows.at(x, y) = std::uint16_t(sum);
    }
  }
  std::vector<int> sums(std::size_t(mask.width), 0);
  for (int y = -r; y < mask.height; ++y) {
    for (int x = 0; x < mask.width; ++x) {
      int& sum = sums[std::size_t(x)];
      if (y + r < mask.height) sum += rows.at(x, y + r);
      if (y - r - 1 >= 0) sum -= rows.at(x, y - r - 1);
      if (y >= 0) result.at(x, y) = std::uint16_t(sum);
    }
  }
  return result;
}

// What most cells of the square around are.
Mask majority(const Mask& mask, int r) {
  const Distances around = set_around(mask, r);
  Mask result(mask.width, mask.height);
  for (std::size_t i = 0; i < result.data.size(); ++i) result.data[i] = 2 * around.data[i] > (2 * r + 1) * (2 * r + 1);
  return result;
}

// The part of the set cells that squares of 2 r + 1 cells, all of them set, cover: what is narrower goes.
Mask opened(const Mask& mask, int r) {
  const Distances around = set_around(mask, r);
  Mask centres(mask.width, mask.height);
  for (std::size_t i = 0; i < centres.data.size(); ++i) centres.data[i] = around.data[i] == (2 * r + 1) * (2 * r + 1);
  const Distances covering = set_around(centres, r);
  Mask result(mask.width, mask.height);
  for (std::size_t i = 0; i < result.data.size(); ++i) result.data[i] = covering.data[i] > 0;
  return result;
}

Mask either(const Mask& a, const Mask& b) {
  Mask result = a;
  for (std::size_t i = 0; i < result.data.size(); ++i) result.data[i] |= b.data[i];
  return result;
}

// An area of connected cells.
struct Area {
  std::vector<std::size_t> cells;
  int left, right, top, bottom;
};

// The area around a cell, which is marked as visited.
Area area_around(std::size_t start, Mask& visited) {
  const auto width = std::size_t(visited.width);
  Area area{{start}, visited.width, -1, visited.height, -1};
  visited.data[start] = 1;
  for (std::size_t next = 0; next < area.cells.size(); ++next) {
    const std::size_t i = area.cells[next];
    const int x = int(i % width), y = int(i / width);
    area.left = std::min(area.left, x), area.right = std::max(area.right, x);
    area.top = std::min(area.top, y), area.bottom = std::max(area.bottom, y);
    const auto visit = [&](bool there, std::size_t to) {
      if (!there || visited.data[to]) return;
      visited.data[to] = 1;
      area.cells.push_back(to);
    };
    visit(x > 0, i - 1), visit(x + 1 < visited.width, i + 1);
    visit(y > 0, i - width), visit(y + 1 < visited.height, i + width);
  }
  return area;
}

// Sets the connected areas outside `walls` that do not reach the border, when more than half of their cells are set or
// when they are no wider and no higher than `widest`.
void fill_enclosures(const Mask& walls, int widest, Mask& mask) {
  Mask visited = walls;
  for (std::size_t start = 0; start < walls.data.size(); ++start) {
    if (visited.data[start]) continue;
    const Area area = area_around(start, visited);
    if (area.left == 0 || area.top == 0 || area.right + 1 == walls.width || area.bottom + 1 == walls.height) continue;
    const auto set = std::size_t(
        std::count_if(area.cells.begin(), area.cells.end(), [&](std::size_t i) { return mask.data[i] != 0; }));
    if (2 * set > area.cells.size() || std::max(area.right - area.left, area.bottom - area.top) < widest)
      for (const std::size_t i : area.cells) mask.data[i] = 1;
  }
}

Mask measured_cells(const SurfaceTile& tile) {
  Mask mask(tile.state.width, tile.state.height);
  for (std::size_t i = 0; i < mask.data.size(); ++i)
    mask.data[i] = tile.state.data[i] == std::uint8_t(CellState::kMeasured);
  return mask;
}

// The measured cells at the rims of holes, as the finest level of a pyramid.
HeightLevel rims(const SurfaceTile& tile, const Mask& measured, std::int64_t column, std::int64_t row, double cell_m) {
  constexpr int kAround = (2 * HoleFilling::kRim + 1) * (2 * HoleFilling::kRim + 1);
  const Distances around = set_around(measured, HoleFilling::kRim);
  HeightLevel level(column, row, measured.width, measured.height, cell_m, kStepCells * cell_m);
  for (std::size_t i = 0; i < measured.data.size(); ++i) {
    if (!measured.data[i] || around.data[i] == kAround) continue;
    level.height_m.data[i] = tile.height_m.data[i];
    level.sigma_m.data[i] = tile.sigma_m.data[i];
    level.weight.data[i] = 1;
  }
  return level;
}

HeightLevel part_of(const HeightLevel& level, std::int64_t column, std::int64_t row, int width, int height) {
  HeightLevel part(column, row, width, height, level.cell_m, level.step_m);
  for (int y = 0; y < height; ++y) {
    const int v = int(std::clamp<std::int64_t>(row + y - level.row, 0, level.weight.height - 1));
    for (int x = 0; x < width; ++x) {
      const int u = int(std::clamp<std::int64_t>(column + x - level.column, 0, level.weight.width - 1));
      part.height_m.at(x, y) = level.height_m.at(u, v);
      part.sigma_m.at(x, y) = level.sigma_m.at(u, v);
      part.weight.at(x, y) = level.weight.at(u, v);
    }
  }
  return part;
}

}  // namespace

HoleFilling::HoleFilling(std::int64_t column, std::int64_t row, std::int64_t width, std::int64_t height, double cell_m,
                         int widest_cells)
    : cell_m_(cell_m), widest_cells_(widest_cells) {
  // One more block on each side: what lies outside is connected around the model.
  const std::int64_t left = floor_div(column, kBlock) - 1, top = floor_div(row, kBlock) - 1;
  const std::int64_t right = floor_div(column + width - 1, kBlock) + 1,
                     bottom = floor_div(row + height - 1, kBlock) + 1;
  blocks_ = HeightLevel(left, top, int(right - left + 1), int(bottom - top + 1), kBlock * cell_m, kStepCells * cell_m);
  solid_ = Mask(blocks_.weight.width, blocks_.weight.height);
}

void HoleFilling::add(const SurfaceTile& tile, const CellWindow& inside) {
  const Mask measured = measured_cells(tile);
  const HeightLevel wider = rims(tile, measured, inside.column - kRim, inside.row - kRim, cell_m_);
  const HeightLevel level = part_of(wider, inside.column, inside.row, inside.width, inside.height);
  std::vector<int> counts(std::size_t(inside.width / kBlock) * std::size_t(inside.height / kBlock), 0);
  for (int y = 0; y < inside.height; ++y)
    for (int x = 0; x < inside.width; ++x)
      counts[std::size_t(y / kBlock * (inside.width / kBlock) + x / kBlock)] += measured.at(x + kRim, y + kRim);
  const HeightLevel blocks = coarser(coarser(coarser(level)));
  for (int y = 0; y < blocks.weight.height; ++y) {
    for (int x = 0; x < blocks.weight.width; ++x) {
      const std::int64_t u = blocks.column + x - blocks_.column, v = blocks.row + y - blocks_.row;
      if (u < 0 || v < 0 || u >= solid_.width || v >= solid_.height) continue;  // nothing is measured there
      blocks_.height_m.at(int(u), int(v)) = blocks.height_m.at(x, y);
      blocks_.sigma_m.at(int(u), int(v)) = blocks.sigma_m.at(x, y);
      blocks_.weight.at(int(u), int(v)) = blocks.weight.at(x, y);
      solid_.at(int(u), int(v)) = 4 * counts[std::size_t(y * blocks.weight.width + x)] >= kBlock * kBlock;
    }
  }
}

void HoleFilling::prepare() {
  if (widest_cells_ < 1) return;
  fill_all(blocks_);
  find_holes();
}

void HoleFilling::find_holes() {
  shut_in_ = Mask(solid_.width, solid_.height);
  if (widest_cells_ < kPinhole) return;
  const int widest = (widest_cells_ + kBlock / 2) / kBlock;
  const Mask lines = lines_between(solid_, widest);
  for (std::size_t i = 0; i < lines.data.size(); ++i) shut_in_.data[i] = lines.data[i] >= 3;
  fill_enclosures(solid_, widest, shut_in_);
  shut_in_ = majority(shut_in_, 1);
  // Boundary artefacts and isolated components before a bay of the outline throw rays into it, as broad as they are.
  const Mask broad = opened(either(solid_, shut_in_), kRayReach);
  for (std::size_t i = 0; i < broad.data.size(); ++i) shut_in_.data[i] &= broad.data[i];
  // What is left within areas that are filled goes with them.
  fill_enclosures(either(solid_, shut_in_), widest, shut_in_);
}

CellWindow HoleFilling::with_margin(const CellWindow& inside) {
  const std::int64_t left = floor_div(inside.column, kBlock) * kBlock, top = floor_div(inside.row, kBlock) * kBlock;
  const std::int64_t right = floor_div(inside.column + inside.width + kBlock - 1, kBlock) * kBlock;
  const std::int64_t bottom = floor_div(inside.row + inside.height + kBlock - 1, kBlock) * kBlock;
  return {left - kMargin, top - kMargin, int(right - left) + 2 * kMargin, int(bottom - top) + 2 * kMargin};
}

// Bilinear between the centres of the blocks, so that the outline does not show them.
bool HoleFilling::shut_in(std::int64_t column, std::int64_t row) const {
  // Twice the distance from the centre of the block to the upper left, in cells.
  const std::int64_t x2 = 2 * column + 1 - kBlock, y2 = 2 * row + 1 - kBlock;
  const std::int64_t block_x = floor_div(x2, 2 * kBlock), block_y = floor_div(y2, 2 * kBlock);
  const int a = int(x2 - block_x * 2 * kBlock), b = int(y2 - block_y * 2 * kBlock);
  const auto at = [&](std::int64_t u, std::int64_t v) {
    u -= blocks_.column, v -= blocks_.row;
    return u >= 0 && v >= 0 && u < shut_in_.width && v < shut_in_.height ? int(shut_in_.at(int(u), int(v))) : 0;
  };
  const int sum = (2 * kBlock - b) * ((2 * kBlock - a) * at(block_x, block_y) + a * at(block_x + 1, block_y)) +
                  b * ((2 * kBlock - a) * at(block_x, block_y + 1) + a * at(block_x + 1, block_y + 1));
  return 2 * sum >= 4 * kBlock * kBlock;
}

Raster<std::uint8_t> HoleFilling::cells_to_fill(const Raster<std::uint8_t>& measured, const CellWindow& wide) const {
  constexpr int kSmoothed = 4;
  const Mask narrow = lines_between(measured, std::min(widest_cells_, kPinhole - 1));
  Mask covered = measured;
  for (int y = 0; y < covered.height; ++y)
    for (int x = 0; x < covered.width; ++x)
      if (!covered.at(x, y)) covered.at(x, y) = narrow.at(x, y) > 0 || shut_in(wide.column + x, wide.row + y);
  Mask fill = majority(covered, kSmoothed);
  for (std::size_t i = 0; i < fill.data.size(); ++i) fill.data[i] = fill.data[i] && !measured.data[i];
  return fill;
}

SurfaceTile HoleFilling::filled(const SurfaceTile& tile, const CellWindow& inside) const {
  const CellWindow wide = with_margin(inside);
  const TilePart part{int(inside.column - wide.column), int(inside.row - wide.row), inside.width, inside.height};
  SurfaceTile result = cropped(tile, part);
  if (widest_cells_ < 1) return result;
  const Mask measured = measured_cells(tile), fill = cells_to_fill(measured, wide);
  bool any = false;
  for (int y = 0; y < part.height && !any; ++y)
    any = std::any_of(fill.row(part.row + y) + part.column, fill.row(part.row + y) + part.column + part.width,
                      [](std::uint8_t set) { return set != 0; });
  if (!any) return result;
  HeightLevel cells = rims(tile, measured, wide.column, wide.row, cell_m_);
  HeightLevel twos = coarser(cells), fours = coarser(twos);
  for (std::size_t i = 0; i < measured.data.size(); ++i)
    if (measured.data[i]) cells.weight.data[i] = 1;  // nothing to fill there, rim or not
  fill_from(part_of(blocks_, wide.column / kBlock, wide.row / kBlock, wide.width / kBlock, wide.height / kBlock),
            fours);
  fill_from(fours, twos);
  fill_from(twos, cells);
  for (int y = 0; y < part.height; ++y) {
    for (int x = 0; x < part.width; ++x) {
      if (!fill.at(part.column + x, part.row + y)) continue;
      result.height_m.at(x, y) = cells.height_m.at(part.column + x, part.row + y);
      result.sigma_m.at(x, y) = cells.sigma_m.at(part.column + x, part.row + y);
      result.state.at(x, y) = std::uint8_t(CellState::kInterpolated);
    }
  }
  return result;
}

}  // namespace collinea
