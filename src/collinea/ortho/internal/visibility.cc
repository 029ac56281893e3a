// SPDX-License-Identifier: Apache-2.0
#include "collinea/ortho/internal/visibility.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace collinea {
namespace {

constexpr int kBlock = OrthoPatch::kBlock;

}  // namespace

double rim_m(const HeightField& surface, double cell_m) {
  return cell_m * (1 + std::ceil(1.5 * surface.grid.cell_m / cell_m));
}

Visibility::Visibility(const OrthoPatch& patch, std::vector<const View*> views, int edge_cells)
    : patch_(patch), views_(std::move(views)), edge_cells_(std::min(edge_cells, kBlock)), layers_(views_.size()) {
  block_low_ = FloatImage(patch.blocks_across(), patch.blocks_down(), 1, std::numeric_limits<float>::quiet_NaN());
  block_high_ = block_low_;
  for (int y = 0; y < patch.heights_m.height; ++y) {
    for (int x = 0; x < patch.heights_m.width; ++x) {
      const float z = patch.heights_m.at(x, y);
      if (std::isnan(z)) continue;
      float &low = block_low_.at(x / kBlock, y / kBlock), &high = block_high_.at(x / kBlock, y / kBlock);
      if (!(low <= z)) low = z;
      if (!(high >= z)) high = z;
    }
  }
}

bool Visibility::sees(int view, int x, int y) {
  const std::size_t v = std::size_t(view);
  if (std::isnan(patch_.heights_m.at(x, y))) return false;
  return final_state(v, x / kBlock, y / kBlock) == State::kAll || layers_[v].final_mask.at(x, y);
}

bool Visibility::sees_barely(int view, int x, int y) {
  const std::size_t v = std::size_t(view);
  if (std::isnan(patch_.heights_m.at(x, y))) return false;
  if (hidden_around(v, x, y, 1) > 0) return false;
  return 5 * hidden_around(v, x, y, edge_cells_) <= (2 * edge_cells_ + 1) * (2 * edge_cells_ + 1);
}

bool Visibility::sees_past_small_things(int view, int x, int y) const {
  const View& from = *views_[std::size_t(view)];
  const float height_m = patch_.heights_m.at(x, y);
  if (std::isnan(height_m)) return false;
  if (!on_image(std::size_t(view), x, y)) return false;
  const double u = patch_.surface_x(patch_.grid.east_of(patch_.column + x + 0.5));
  const double v = patch_.surface_y(patch_.grid.north_of(patch_.row + y + 0.5));
  const double camera_x = patch_.surface_x(from.centre_in_map.x()), camera_y = patch_.surface_y(from.centre_in_map.y());
  const auto hides = [&](int dx, int dy) {
    return patch_.occluders.wide_ones_hide(u + dx, v + dy, double(height_m), camera_x + dx, camera_y + dy,
                                           from.centre_in_map.z());
  };
  if (hides(0, 0)) return false;
  // Wide things have lost so much at their edges: it is made up for here, and two cells more are kept away from them.
  for (const int r : {Occluders::kThin, Occluders::kThin + 2})
    if (hides(-r, -r) || hides(r, -r) || hides(-r, r) || hides(r, r)) return false;
  return true;
}

int Visibility::hidden_around(std::size_t view, int x, int y, int radius) {
  int hidden = 0;
  for (int j = std::max(0, y - radius); j <= std::min(patch_.heights_m.height - 1, y + radius); ++j)
    for (int i = std::max(0, x - radius); i <= std::min(patch_.heights_m.width - 1, x + radius); ++i)
      hidden += raw_state(view, i / kBlock, j / kBlock) == State::kMask && !layers_[view].raw_mask.at(i, j);
  return hidden;
}

bool Visibility::on_image(std::size_t view, int x, int y) const {
  const Layer& layer = layers_[view];
  if (!layer.imaged.empty() &&
      layer.imaged[std::size_t(y / kBlock * patch_.blocks_across() + x / kBlock)] == State::kAll)
    return true;
  const auto pixel = pixel_of(*views_[view], patch_.world_at(x, y));
  return pixel && shows(*views_[view], *pixel);
}

bool Visibility::hidden(const View& view, int x, int y) const {
  const double east_m = patch_.grid.east_of(patch_.column + x + 0.5),
               north_m = patch_.grid.north_of(patch_.row + y + 0.5);
  return patch_.occluders.hide(patch_.surface_x(east_m), patch_.surface_y(north_m), double(patch_.heights_m.at(x, y)),
                               patch_.surface_x(view.centre_in_map.x()), patch_.surface_y(view.centre_in_map.y()),
                               view.centre_in_map.z());
}

bool Visibility::whole_block_on_image(const View& view, int block_x, int block_y) const {
  if (view.masks) return false;  // a mask may lie anywhere in it
  const float low_m = block_low_.at(block_x, block_y), high_m = block_high_.at(block_x, block_y);
  for (int corner = 0; corner < 8; ++corner) {
    const double x = (block_x + (corner & 1)) * kBlock, y = (block_y + (corner >> 1 & 1)) * kBlock;
    const auto pixel = pixel_of(view, patch_.lattice.at(x, y, double(corner & 4 ? high_m : low_m)));
    if (!pixel || !well_inside(view, *pixel)) return false;
  }
  return true;
}

// Steps from the block towards the camera: nowhere may the surface, as far aside as the block is wide, reach up to the
// lowest line of sight.
bool Visibility::clear_towards(const View& view, int block_x, int block_y, float low_m, float high_m) const {
  const MapGrid& grid = patch_.grid;
  const double half = kBlock / 2.0, surface_cell_m = patch_.surface_grid.cell_m;
  const double x = patch_.surface_x(grid.east_of(patch_.column + block_x * kBlock + half));
  const double y = patch_.surface_y(grid.north_of(patch_.row + block_y * kBlock + half));
  const double camera_x = patch_.surface_x(view.centre_in_map.x()), camera_y = patch_.surface_y(view.centre_in_map.y());
  const double radius = kBlock * grid.cell_m / surface_cell_m * std::sqrt(0.5);
  const double step = Occluders::kCeilingReach - radius;
  if (step < 1) return false;  // surface cells much smaller than ours: look cell by cell
  const double run = std::hypot(camera_x - x, camera_y - y), rise = view.centre_in_map.z() - high_m;
  if (!(rise > 0)) return false;
  const double rise_per_cell = rise / (run + radius);
  for (double s = 0; s <= run; s += step) {
    const double u = x + (run > 0 ? s / run : 0) * (camera_x - x), v = y + (run > 0 ? s / run : 0) * (camera_y - y);
    const double line_m = low_m + surface_cell_m + rise_per_cell * std::max(0.0, s - step);
    if (patch_.occluders.ceiling_m(u, v) > line_m) return false;
    if (line_m > patch_.occluders.highest_m()) return true;
  }
  return true;
}

Visibility::State Visibility::raw_state(std::size_t view, int block_x, int block_y) {
  Layer& layer = layers_[view];
  if (layer.raw.empty()) {
    layer.raw.assign(std::size_t(patch_.blocks_across() * patch_.blocks_down()), State::kUnknown);
    layer.final = layer.imaged = layer.raw;
  }
  const std::size_t block = std::size_t(block_y * patch_.blocks_across() + block_x);
  State& state = layer.raw[block];
  if (state != State::kUnknown) return state;
  if (std::isnan(block_low_.at(block_x, block_y))) return state = State::kAll;
  if (whole_block_on_image(*views_[view], block_x, block_y)) {
    layer.imaged[block] = State::kAll;
    if (clear_towards(*views_[view], block_x, block_y, block_low_.at(block_x, block_y),
                      block_high_.at(block_x, block_y)))
      return state = State::kAll;
  }
  if (layer.raw_mask.empty()) {
    layer.raw_mask = Mask(patch_.blocks_across(), patch_.blocks_down());
    layer.final_mask = layer.raw_mask;
  }
  bool all = true;
  for (int y = block_y * kBlock; y < (block_y + 1) * kBlock; ++y) {
    for (int x = block_x * kBlock; x < (block_x + 1) * kBlock; ++x) {
      // A cell without height hides nothing and must not make its neighbours hidden.
      const bool seen = std::isnan(patch_.heights_m.at(x, y)) || (on_image(view, x, y) && !hidden(*views_[view], x, y));
      layer.raw_mask.set(x, y, seen);
      all &= seen;
    }
  }
  return state = all ? State::kAll : State::kMask;
}

Visibility::State Visibility::final_state(std::size_t view, int block_x, int block_y) {
  if (!layers_[view].final.empty()) {
    const State known = layers_[view].final[std::size_t(block_y * patch_.blocks_across() + block_x)];
    if (known != State::kUnknown) return known;
  }
  bool all = true;
  for (int v = std::max(0, block_y - 1); v <= std::min(patch_.blocks_down() - 1, block_y + 1); ++v)
    for (int u = std::max(0, block_x - 1); u <= std::min(patch_.blocks_across() - 1, block_x + 1); ++u)
      all &= raw_state(view, u, v) == State::kAll;
  Layer& layer = layers_[view];
  if (!all) make_final_mask(layer, block_x, block_y);
  return layer.final[std::size_t(block_y * patch_.blocks_across() + block_x)] = all ? State::kAll : State::kMask;
}

// Erodes what is seen by a square, separably: first along the rows that are needed, then along columns.
void Visibility::make_final_mask(Layer& layer, int block_x, int block_y) const {
  const int width = patch_.heights_m.width, height = patch_.heights_m.height, r = edge_cells_;
  const auto raw_seen = [&](int x, int y) {
    const State state = layer.raw[std::size_t(y / kBlock * patch_.blocks_across() + x / kBlock)];
    return state == State::kAll || layer.raw_mask.at(x, y);
  };
  const int top = std::max(0, block_y * kBlock - r), bottom = std::min(height, (block_y + 1) * kBlock + r);
  Raster<std::uint8_t> rows(kBlock, bottom - top, 1, 1);
  for (int y = top; y < bottom; ++y)
    for (int i = 0; i < kBlock; ++i)
      for (int x = std::max(0, block_x * kBlock + i - r); x <= std::min(width - 1, block_x * kBlock + i + r); ++x)
        if (!raw_seen(x, y)) rows.at(i, y - top) = 0;
  for (int j = 0; j < kBlock; ++j) {
    const int y = block_y * kBlock + j;
    for (int i = 0; i < kBlock; ++i) {
      std::uint8_t seen = 1;
      for (int v = std::max(top, y - r); v <= std::min(bottom - 1, y + r); ++v) seen &= rows.at(i, v - top);
      layer.final_mask.set(block_x * kBlock + i, y, seen != 0);
    }
  }
}

}  // namespace collinea
