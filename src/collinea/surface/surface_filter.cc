// SPDX-License-Identifier: Apache-2.0
#include "collinea/surface/surface_filter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
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

bool is_speck(const SurfaceTile& tile, Cell start, double cell_m) {
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

struct Bridge {
  double height_m, sigma_m, weight;
};

std::optional<Cell> first_measured(const SurfaceTile& tile, Cell from, int dx, int dy, int reach) {
  for (int step = 1; step <= reach; ++step)
    if (has(tile, CellState::kMeasured, from.x + step * dx, from.y + step * dy))
      return Cell{from.x + step * dx, from.y + step * dy};
  return std::nullopt;
}

constexpr double kPinholeCells = 16;  // wider gaps must be enclosed

// The height of an empty cell by the measured ones on both sides along one direction.
std::optional<Bridge> bridge(const SurfaceTile& tile, Cell cell, int dx, int dy, double cell_m, int widest_cells) {
  const double stride = std::hypot(dx, dy);
  const int reach = int(widest_cells / stride);
  const auto a = first_measured(tile, cell, dx, dy, reach);
  if (!a) return std::nullopt;
  const auto b = first_measured(tile, cell, -dx, -dy, reach);
  if (!b) return std::nullopt;
  const double to_a = std::hypot(a->x - cell.x, a->y - cell.y), to_b = std::hypot(b->x - cell.x, b->y - cell.y);
  if (to_a + to_b - stride > widest_cells) return std::nullopt;  // the cells between the two
  const double za = tile.height_m.at(a->x, a->y), zb = tile.height_m.at(b->x, b->y), gap = to_a + to_b;
  const double sigma = std::max(tile.sigma_m.at(a->x, a->y), tile.sigma_m.at(b->x, b->y)) + std::abs(za - zb) / 4;
  const bool smooth = one_surface(tile, *a, *b, cell_m);
  return Bridge{smooth ? (za * to_b + zb * to_a) / gap : std::min(za, zb), sigma, 1 / (gap * gap)};
}

std::optional<Bridge> filled(const SurfaceTile& tile, Cell cell, double cell_m, int widest_cells) {
  constexpr std::array<std::array<int, 2>, 4> kDirections = {{{1, 0}, {0, 1}, {1, 1}, {1, -1}}};
  std::array<Bridge, 4> bridges;
  std::size_t count = 0;
  for (const auto& [dx, dy] : kDirections)
    if (const auto found = bridge(tile, cell, dx, dy, cell_m, widest_cells)) bridges[count++] = *found;
  if (count == 0) return std::nullopt;
  // A wide gap bridged in one direction only is a bay of the border or the space between two things, not a hole.
  const auto shortest = std::max_element(bridges.begin(), bridges.begin() + std::ptrdiff_t(count),
                                         [](const Bridge& a, const Bridge& b) { return a.weight < b.weight; });
  if (shortest->weight < 1.0 / (kPinholeCells * kPinholeCells) && count < 3) return std::nullopt;
  double lowest = bridges[0].height_m;
  for (std::size_t i = 1; i < count; ++i) lowest = std::min(lowest, bridges[i].height_m);
  Bridge mean{0, 0, 0};
  for (std::size_t i = 0; i < count; ++i) {
    const Bridge& b = bridges[i];
    if (b.height_m > lowest + 1.75 * cell_m * widest_cells) continue;
    mean.height_m += b.weight * (b.height_m - lowest);
    mean.sigma_m += b.weight * b.sigma_m;
    mean.weight += b.weight;
  }
  return Bridge{lowest + mean.height_m / mean.weight, mean.sigma_m / mean.weight, 1};
}

}  // namespace

SurfaceTile::SurfaceTile(int width, int height)
    : height_m(width, height, 1, kNoHeight),
      sigma_m(width, height, 1, kNoHeight),
      state(width, height),
      count(width, height) {}

void remove_specks(SurfaceTile& tile, double cell_m) {
  std::vector<Cell> specks;
  for (int y = 0; y < tile.state.height; ++y)
    for (int x = 0; x < tile.state.width; ++x)
      if (has(tile, CellState::kMeasured, x, y) && is_speck(tile, {x, y}, cell_m)) specks.push_back({x, y});
  for (const Cell& speck : specks) empty_cell(tile, speck);
}

void fill_holes(SurfaceTile& tile, double cell_m, int widest_cells) {
  if (widest_cells < 1) return;
  for (int y = 0; y < tile.state.height; ++y) {
    for (int x = 0; x < tile.state.width; ++x) {
      if (!has(tile, CellState::kEmpty, x, y)) continue;
      const auto found = filled(tile, {x, y}, cell_m, widest_cells);
      if (!found) continue;
      tile.height_m.at(x, y) = float(found->height_m);
      tile.sigma_m.at(x, y) = float(found->sigma_m);
      tile.state.at(x, y) = std::uint8_t(CellState::kInterpolated);
    }
  }
}

}  // namespace collinea
