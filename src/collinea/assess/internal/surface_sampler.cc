// SPDX-License-Identifier: Apache-2.0
#include "collinea/assess/internal/surface_sampler.h"

#include <algorithm>
#include <cmath>

namespace collinea {
namespace {

constexpr int kTile = 256;  // cells a side
constexpr int kMargin = 2;  // round a tile: bilinear and slopes need them
constexpr int kMostTiles = 128;

Eigen::Vector2d slope_at(const FloatImage& heights, int x, int y, double cell_m) {
  const float middle = heights.at(x, y);
  const auto height = [&](int dx, int dy) {
    const int column = x + dx, row = y + dy;
    if (column < 0 || row < 0 || column >= heights.width || row >= heights.height) return double(middle);
    const float there = heights.at(column, row);
    return double(std::isnan(there) ? middle : there);
  };
  const double east =
      height(1, -1) + 2 * height(1, 0) + height(1, 1) - height(-1, -1) - 2 * height(-1, 0) - height(-1, 1);
  const double north =
      height(-1, -1) + 2 * height(0, -1) + height(1, -1) - height(-1, 1) - 2 * height(0, 1) - height(1, 1);
  return Eigen::Vector2d(east, north) / (8 * cell_m);
}

}  // namespace

Result<const SurfaceSampler::Tile*> SurfaceSampler::tile_at(int column, int row) {
  const int tiles_across = (field_.grid.width + kTile - 1) / kTile;
  const int key = row / kTile * tiles_across + column / kTile;
  if (const auto known = position_of_.find(key); known != position_of_.end()) {
    tiles_.splice(tiles_.begin(), tiles_, known->second);
    return &tiles_.front().second;
  }
  Tile tile;
  tile.column = std::max(column / kTile * kTile - kMargin, 0);
  tile.row = std::max(row / kTile * kTile - kMargin, 0);
  const int width = std::min((column / kTile + 1) * kTile + kMargin, field_.grid.width) - tile.column;
  const int height = std::min((row / kTile + 1) * kTile + kMargin, field_.grid.height) - tile.row;
  COLLINEA_TRY(tile.heights, field_.read(tile.column, tile.row, width, height));
  if (field_.read_sigma) {
    COLLINEA_TRY(tile.sigmas, field_.read_sigma(tile.column, tile.row, width, height));
  }
  if (int(tiles_.size()) == kMostTiles) {
    position_of_.erase(tiles_.back().first);
    tiles_.pop_back();
  }
  tiles_.emplace_front(key, std::move(tile));
  position_of_[key] = tiles_.begin();
  return &tiles_.front().second;
}

Result<SurfaceAt> SurfaceSampler::at(const Eigen::Vector2d& on_map) {
  const MapGrid& grid = field_.grid;
  const double x = grid.column_of(on_map.x()) - 0.5, y = grid.row_of(on_map.y()) - 0.5;  // between middles of cells
  SurfaceAt found;
  if (!(x >= 0 && y >= 0 && x <= grid.width - 1 && y <= grid.height - 1)) return found;
  const int column = std::min(int(x), std::max(grid.width - 2, 0)),
            row = std::min(int(y), std::max(grid.height - 2, 0));
  COLLINEA_TRY(const Tile* tile, tile_at(column, row));
  const int left = column - tile->column, top = row - tile->row;
  const int right = std::min(left + 1, tile->heights.width - 1), below = std::min(top + 1, tile->heights.height - 1);
  const double u = x - column, v = y - row;
  found.height_m = (1 - v) * ((1 - u) * tile->heights.at(left, top) + u * tile->heights.at(right, top)) +
                   v * ((1 - u) * tile->heights.at(left, below) + u * tile->heights.at(right, below));
  if (std::isnan(found.height_m)) return found;
  const int near_x = u < 0.5 ? left : right, near_y = v < 0.5 ? top : below;
  found.slope = (1 - v) * ((1 - u) * slope_at(tile->heights, left, top, grid.cell_m) +
                           u * slope_at(tile->heights, right, top, grid.cell_m)) +
                v * ((1 - u) * slope_at(tile->heights, left, below, grid.cell_m) +
                     u * slope_at(tile->heights, right, below, grid.cell_m));
  if (field_.read_sigma) found.sigma_m = double(tile->sigmas.at(near_x, near_y));
  return found;
}

}  // namespace collinea
