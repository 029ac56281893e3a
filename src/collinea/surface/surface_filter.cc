// SPDX-License-Identifier: Apache-2.0
#include "collinea/surface/surface_filter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace collinea {
namespace {

struct Cell {
  int x, y;
  friend bool operator==(const Cell&, const Cell&) = default;
};

bool has(const SurfaceTile& tile, CellState state, int x, int y) {
  return x >= 0 && y >= 0 && x < tile.state.width && y < tile.state.height &&
         tile.state.at(x, y) == std::uint8_t(state);
}

// No step between two cells: what a slope of 60 degrees and the noise of both explain.
bool one_surface(const SurfaceTile& tile, Cell a, Cell b, double cell_m) {
  const int dx = a.x - b.x, dy = a.y - b.y;
  const double run_m = cell_m * std::sqrt(double(dx * dx + dy * dy));
  const double noise_m = 3.0 * double(std::max(tile.sigma_m.at(a.x, a.y), tile.sigma_m.at(b.x, b.y)));
  return std::abs(double(tile.height_m.at(a.x, a.y)) - double(tile.height_m.at(b.x, b.y))) <= 1.75 * run_m + noise_m;
}

bool is_speckle(const SurfaceTile& tile, Cell start, double cell_m) {
  std::array<Cell, kSmallestPatch> patch;
  int size = 0;
  patch[std::size_t(size++)] = start;
  for (int next = 0; next < size; ++next) {
    const Cell from = patch[std::size_t(next)];
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const Cell to{from.x + dx, from.y + dy};
        if (!has(tile, CellState::kMeasured, to.x, to.y) || !one_surface(tile, from, to, cell_m)) continue;
        if (std::find(patch.begin(), patch.begin() + size, to) != patch.begin() + size) continue;
        patch[std::size_t(size++)] = to;
        if (size == kSmallestPatch) return false;
      }
    }
  }
  return true;
}

void empty_cell(SurfaceTile& tile, Cell c) {
  tile.height_m.at(c.x, c.y) = tile.sigma_m.at(c.x, c.y) = kNoHeight;
  tile.state.at(c.x, c.y) = std::uint8_t(CellState::kEmpty);
  tile.count.at(c.x, c.y) = 0;
}

template <class T>
Raster<T> cropped_raster(const Raster<T>& from, const TilePart& part) {
  Raster<T> to(part.width, part.height);
  for (int y = 0; y < to.height; ++y) std::copy_n(from.row(part.row + y) + part.column, to.width, to.row(y));
  return to;
}

}  // namespace

SurfaceTile::SurfaceTile(int width, int height)
    : height_m(width, height, 1, kNoHeight),
      sigma_m(width, height, 1, kNoHeight),
      state(width, height),
      count(width, height) {}

SurfaceTile cropped(const SurfaceTile& tile, const TilePart& part) {
  SurfaceTile result;
  result.height_m = cropped_raster(tile.height_m, part);
  result.sigma_m = cropped_raster(tile.sigma_m, part);
  result.state = cropped_raster(tile.state, part);
  result.count = cropped_raster(tile.count, part);
  return result;
}

void remove_speckles(SurfaceTile& tile, double cell_m) {
  std::vector<Cell> speckles;
  for (int y = 0; y < tile.state.height; ++y)
    for (int x = 0; x < tile.state.width; ++x)
      if (has(tile, CellState::kMeasured, x, y) && is_speckle(tile, {x, y}, cell_m)) speckles.push_back({x, y});
  for (const Cell& speckle : speckles) empty_cell(tile, speckle);
}

}  // namespace collinea
