// SPDX-License-Identifier: Apache-2.0
#include "collinea/surface/internal/gridding.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "collinea/surface/internal/cell_fit.h"

namespace collinea {
namespace {

static_assert(sizeof(GridPoint) == 32);

constexpr int kReachCells = 2;
static_assert(kReachCells >= kCellReach);
constexpr int kBandRows = 64;

// Points sorted by cell, and within a cell by height, so that sums do not depend on the order in which they came.
struct SortedPoints {
  CellWindow window;
  std::vector<GridPoint> points;
  std::vector<std::uint32_t> first;  // of each cell of the window, row by row; one more at the end

  SortedPoints(std::vector<GridPoint> unsorted, const CellWindow& of);
  [[nodiscard]] std::size_t cell_of(const GridPoint& p) const {
    const auto x = std::int64_t(std::floor(p.column)) - window.column, y = std::int64_t(std::floor(p.row)) - window.row;
    if (x < 0 || y < 0 || x >= window.width || y >= window.height) return std::numeric_limits<std::size_t>::max();
    return std::size_t(y) * std::size_t(window.width) + std::size_t(x);
  }
};

SortedPoints::SortedPoints(std::vector<GridPoint> unsorted, const CellWindow& of) : window(of) {
  const std::size_t cells = std::size_t(window.width) * std::size_t(window.height);
  first.assign(cells + 1, 0);
  std::erase_if(unsorted, [&](const GridPoint& p) { return cell_of(p) >= cells; });
  for (const GridPoint& p : unsorted) ++first[cell_of(p) + 1];
  for (std::size_t i = 0; i < cells; ++i) first[i + 1] += first[i];
  points.resize(unsorted.size());
  std::vector<std::uint32_t> next(first.begin(), first.end() - 1);
  for (const GridPoint& p : unsorted) points[next[cell_of(p)]++] = p;
  for (std::size_t i = 0; i < cells; ++i) {
    if (first[i + 1] - first[i] < 2) continue;
    std::sort(points.begin() + first[i], points.begin() + first[i + 1], [](const GridPoint& a, const GridPoint& b) {
      return std::tie(a.height_m, a.column, a.row, a.sigma_m) < std::tie(b.height_m, b.column, b.row, b.sigma_m);
    });
  }
}

void gather(const SortedPoints& sorted, int x, int y, std::vector<CellPoint>& near) {
  near.clear();
  const double centre_x = double(sorted.window.column) + x + 0.5, centre_y = double(sorted.window.row) + y + 0.5;
  const std::size_t own = std::size_t(y) * std::size_t(sorted.window.width) + std::size_t(x);
  for (int dy = -kReachCells; dy <= kReachCells; ++dy) {
    // The points of the cells of one row follow each other.
    const std::size_t middle = std::size_t(y + dy) * std::size_t(sorted.window.width) + std::size_t(x);
    for (std::uint32_t i = sorted.first[middle - kReachCells]; i < sorted.first[middle + kReachCells + 1]; ++i) {
      const GridPoint& p = sorted.points[i];
      const double px = p.column - centre_x, py = p.row - centre_y;
      if (px * px + py * py > kCellReach * kCellReach) continue;
      near.push_back({px, py, p.height_m, p.sigma_m, i >= sorted.first[own] && i < sorted.first[own + 1]});
    }
  }
}

// The rows of `tile` from `first_row` on of which `sorted` has all points.
void measure(const SortedPoints& sorted, const Gridding& gridding, int first_row, SurfaceTile& tile) {
  CellFit fit(share_alike(gridding.alike_cells));
  std::vector<CellPoint> near;
  for (int y = 0; y < sorted.window.height - 2 * kReachCells; ++y) {
    for (int x = 0; x < sorted.window.width - 2 * kReachCells; ++x) {
      gather(sorted, x + kReachCells, y + kReachCells, near);
      const auto estimate = fit.estimate(near, gridding.cell_m);
      if (!estimate) continue;
      tile.height_m.at(x, first_row + y) = float(estimate->height_m);
      tile.sigma_m.at(x, first_row + y) = float(estimate->sigma_m);
      tile.state.at(x, first_row + y) = std::uint8_t(CellState::kMeasured);
      tile.count.at(x, first_row + y) = std::uint16_t(std::min(estimate->points, 65535));
    }
  }
}

}  // namespace

int margin_cells() { return kReachCells + kSmallestPatch; }

Result<SurfaceTile> measure_window(const PointsOf& points_of, const CellWindow& window, const Gridding& gridding) {
  SurfaceTile tile;
  const int width = window.width + 2 * kSmallestPatch, height = window.height + 2 * kSmallestPatch;
  for (int row = 0; row < height; row += kBandRows) {
    const int rows = std::min(kBandRows, height - row);
    const CellWindow band{window.column - margin_cells(), window.row - margin_cells() + row, width + 2 * kReachCells,
                          rows + 2 * kReachCells};
    COLLINEA_TRY(auto points, points_of(band));
    if (points.empty()) continue;
    if (tile.state.empty()) tile = SurfaceTile(width, height);
    measure(SortedPoints(std::move(points), band), gridding, row, tile);
  }
  if (tile.state.empty()) return tile;
  remove_speckles(tile, gridding.cell_m);
  return cropped(tile, {kSmallestPatch, kSmallestPatch, window.width, window.height});
}

}  // namespace collinea
