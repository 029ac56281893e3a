// SPDX-License-Identifier: Apache-2.0
#include "collinea/restitution/map_height.h"

#include <algorithm>
#include <cmath>
#include <list>
#include <memory>

namespace collinea {
namespace {

using Eigen::Vector2d;

/// A window of the raster: a tile with a cell more on each side, for heights between cells.
struct Tile {
  int column = 0, row = 0;  // of the tile
  int left = 0, top = 0;    // of the window
  FloatImage heights;
};

class Tiles {
 public:
  explicit Tiles(const HeightField& field) : field_(field) {}

  std::optional<double> height(const Vector2d& on_map) {
    const MapGrid& grid = field_.grid;
    const double column = grid.column_of(on_map.x()), row = grid.row_of(on_map.y());
    if (!(column >= 0 && row >= 0 && column < grid.width && row < grid.height)) return std::nullopt;
    const Tile& tile = tile_with(int(column), int(row));
    const float height = height_at(tile.heights, column - tile.left, row - tile.top, grid.cell_m);
    return std::isfinite(height) ? std::optional<double>(height) : std::nullopt;
  }

 private:
  const Tile& tile_with(int column, int row) {
    const int u = column / kHeightTile, v = row / kHeightTile;
    const auto known = std::ranges::find_if(kept_, [&](const Tile& one) { return one.column == u && one.row == v; });
    if (known != kept_.end()) {
      kept_.splice(kept_.begin(), kept_, known);
      return kept_.front();
    }
    Tile tile{u, v, std::max(u * kHeightTile - 1, 0), std::max(v * kHeightTile - 1, 0), {}};
    const int width = std::min((u + 1) * kHeightTile + 1, field_.grid.width) - tile.left;
    const int height = std::min((v + 1) * kHeightTile + 1, field_.grid.height) - tile.top;
    if (auto heights = field_.read(tile.left, tile.top, width, height)) tile.heights = *std::move(heights);
    kept_.push_front(std::move(tile));
    if (kept_.size() > kMostHeightTiles) kept_.pop_back();
    return kept_.front();
  }

  HeightField field_;
  std::list<Tile> kept_;  // the one used last first
};

}  // namespace

MapHeight heights_by_need(const HeightField& field) {
  return [tiles = std::make_shared<Tiles>(field)](const Vector2d& on_map) { return tiles->height(on_map); };
}

MapHeight heights_by_need(const std::filesystem::path& raster) {
  const auto field = open_height_field(raster);
  return field ? heights_by_need(*field) : MapHeight();
}

SurfaceHeight surface_in_world(const LocalFrame* frame, const MapHeight& surface) {
  if (!surface) return {};
  return [frame, surface](const Vector2d& at) -> std::optional<double> {
    if (!frame) return surface(at);
    // Curvature: a height of the map is that of the world but for their difference at the place.
    const Eigen::Vector3d map = frame->map_from_local({at.x(), at.y(), 0});
    const auto height = map.allFinite() ? surface(map.head<2>()) : std::nullopt;
    return height ? std::optional(*height - map.z()) : std::nullopt;
  };
}

}  // namespace collinea
