// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "collinea/base/parallel.h"
#include "collinea/dense/internal/aggregate.h"
#include "collinea/dense/internal/level.h"
#include "collinea/dense/internal/neighbours.h"

namespace collinea::dense {
namespace {

constexpr int kTileCells = 24;   // a tile is aggregated on its own, which bounds memory
constexpr int kTileOverlap = 2;  // cells around it that take part, so that its border is nobody's border

// With every view beyond kWidestAngle_rad chance has one try more. The views nearest to the reference are used all the
// same when there are no others. One choice serves all labels of a cell: chance must have the same number of tries at
// every depth.
constexpr int kFewestViews = 2;

void reference_region(const GreyImage& image, int left, int top, std::int8_t* region) {
  for (int j = 0; j < kRegionHeight; ++j)
    for (int i = 0; i < kRegionWidth; ++i) {
      const int x = left - kRadius + i, y = top - kRadius + j;
      const bool there = x >= 0 && y >= 0 && x < image.width && y < image.height;
      region[j * kRegionWidth + i] = std::int8_t((there ? image.at(x, y) : 0) - 128);
    }
}

struct CostScratch {
  CellScene scene;
  Smallest smallest;
  alignas(64) std::array<std::int8_t, kRegion> region, sampled;
  alignas(64) std::array<std::uint8_t, kCensusBits * kCellPixels> planes;
  alignas(64) std::array<std::uint8_t, kCellPixels> distance, costs;
};

// Whether a placed view shows the whole cell `shift` beyond its surface.
bool shows_all(const View& view, const Carried& carried, float shift) {
  const auto& b = view.transfer.b;
  for (const int corner : {0, kRegionWidth - 1, kRegion - kRegionWidth, kRegion - 1}) {
    const float z = carried.z[corner] + shift * b[2];
    const float x = (carried.x[corner] + shift * b[0]) / z, y = (carried.y[corner] + shift * b[1]) / z;
    if (!(z > 0 && x >= 0 && y >= 0 && x <= float(view.quads.width) && y <= float(view.quads.height))) return false;
  }
  return true;
}

// Which of the placed views to compare when the cell lies about `shift` beyond its surface: those at small angles.
// Positions in scene.views.
std::vector<std::size_t> views_at_small_angles(const Level& level, const CellScene& scene, float shift) {
  const float middle = scene.inverse_depth[std::size_t(kRegionHeight / 2 * kRegionWidth + kRegionWidth / 2)];
  const float x = float(scene.left) + 0.5f * kCell, y = float(scene.top) + 0.5f * kCell;
  const Eigen::Vector3f ray((x - level.cx) / level.focal_px, (y - level.cy) / level.focal_px, 1);
  const Eigen::Vector3f point = ray / (middle + shift);
  std::vector<std::pair<float, std::size_t>> by_angle;
  for (std::size_t v = 0; v < scene.views.size(); ++v) {
    const Eigen::Vector3f other = point - level.views[std::size_t(scene.views[v])].centre_in_cam;
    by_angle.emplace_back(std::atan2(point.cross(other).norm(), point.dot(other)), v);
  }
  std::sort(by_angle.begin(), by_angle.end());
  std::vector<std::size_t> chosen;
  int whole = 0;
  for (const auto& [angle, v] : by_angle) {
    if (angle > float(kWidestAngle_rad) && whole >= kFewestViews) break;
    chosen.push_back(v);
    whole += shows_all(level.views[std::size_t(scene.views[v])], scene.carried[v], shift);
  }
  return chosen;
}

void cell_costs(const Level& level, const Labels& labels, const Cell& cell, std::uint8_t* volume,
                CostScratch& scratch) {
  CellScene& scene = scratch.scene;
  scene.left = cell.left;
  scene.top = cell.top;
  for (int j = 0; j < kRegionHeight; ++j)
    for (int i = 0; i < kRegionWidth; ++i)
      scene.inverse_depth[std::size_t(j * kRegionWidth + i)] =
          labels.base(cell, cell.left - kRadius + i, cell.top - kRadius + j) + cell.first * labels.step;
  locate_views(level, 0, float(cell.labels - 1) * labels.step, scene);
  reference_region(*level.image, cell.left, cell.top, scratch.region.data());
  census(scratch.region.data(), scratch.planes.data());
  const auto views = views_at_small_angles(level, scene, float(cell.labels) * labels.step / 2);
  for (int k = 0; k < cell.labels; ++k) {
    clear(scratch.smallest);
    const float w = float(k) * labels.step;
    for (const std::size_t v : views) {
      const View& view = level.views[std::size_t(scene.views[v])];
      const auto& b = view.transfer.b;
      sample(view.quads, scene.carried[v], w * b[0], w * b[1], w * b[2], scratch.sampled.data());
      census_distance(scratch.sampled.data(), scratch.planes.data(), scratch.distance.data());
      add(scratch.distance.data(), scratch.smallest);
    }
    cost(scratch.smallest, scratch.costs.data());
    std::uint8_t* out = volume + kGuard + k;
    for (int i = 0; i < kCellPixels; ++i) out[i * cell.stride] = scratch.costs[std::size_t(i)];
  }
}

CellRange widened(const CellRange& tile, const Labels& labels) {
  return {std::max(tile.column0 - kTileOverlap, 0), std::max(tile.row0 - kTileOverlap, 0),
          std::min(tile.column1 + kTileOverlap, labels.columns), std::min(tile.row1 + kTileOverlap, labels.rows)};
}

void take_winners(const Level& level, const Labels& labels, const Volume& volume,
                  const std::vector<std::uint16_t>& sums, const CellRange& tile, FloatImage& result) {
  for (int row = tile.row0; row < tile.row1; ++row)
    for (int column = tile.column0; column < tile.column1; ++column) {
      const Cell& cell = labels.cell(column, row);
      const std::uint16_t* of_cell = sums.data() + volume.offset(column, row);
      for (int y = cell.top; y < std::min(cell.top + kCell, labels.height); ++y)
        for (int x = cell.left; x < std::min(cell.left + kCell, labels.width); ++x) {
          if (level.image->at(x, y) == 0) continue;
          const int pixel = (y - cell.top) * kCell + x - cell.left;
          const float best = winner(of_cell + std::size_t(pixel) * std::size_t(cell.stride), cell.labels);
          result.at(x, y) = labels.base(cell, x, y) + (cell.first + best) * labels.step;
        }
    }
}

void match_tile(const Level& level, const Labels& labels, const Smoothness& smoothness, const CellRange& tile,
                SharedBudget& costs, const Run& run, FloatImage& result) {
  const CellRange range = widened(tile, labels);
  const SharedBudget::Part part = costs.take(bytes_to_match(labels, range));
  if (run.stopped()) return;
  Volume volume = volume_for(labels, range);
  const auto scratch = std::make_unique<CostScratch>();
  for (int row = range.row0; row < range.row1; ++row)
    for (int column = range.column0; column < range.column1; ++column) {
      if (run.stopped()) return;
      cell_costs(level, labels, labels.cell(column, row), volume.costs.data() + volume.offset(column, row), *scratch);
    }
  const auto sums = aggregate(labels, volume, *level.image, smoothness, [&] { return run.stopped(); });
  if (!run.stopped()) take_winners(level, labels, volume, sums, tile, result);
}

}  // namespace

void locate_views(const Level& level, float low, float high, CellScene& scene) {
  scene.views.clear();
  scene.carried.resize(level.views.size());
  for (std::size_t v = 0; v < level.views.size(); ++v) {
    const View& view = level.views[v];
    const auto& b = view.transfer.b;
    Carried& carried = scene.carried[scene.views.size()];
    carry(view.transfer, scene.left - kRadius, scene.top - kRadius, scene.inverse_depth.data(), carried);
    float x0 = std::numeric_limits<float>::max(), x1 = -x0, y0 = x0, y1 = -x0;
    bool in_front = true;
    for (const int corner : {0, kRegionWidth - 1, kRegion - kRegionWidth, kRegion - 1})
      for (const float w : {low, high}) {
        const float z = carried.z[corner] + w * b[2];
        in_front = in_front && z > 1e-6f;
        const float x = (carried.x[corner] + w * b[0]) / z, y = (carried.y[corner] + w * b[1]) / z;
        x0 = std::min(x0, x), x1 = std::max(x1, x), y0 = std::min(y0, y), y1 = std::max(y1, y);
      }
    if (in_front && (x1 < 0 || y1 < 0 || x0 > float(view.quads.width) || y0 > float(view.quads.height))) continue;
    scene.views.push_back(int(v));
  }
}

std::size_t usual_bytes_to_match() {
  constexpr std::size_t kCells = kTileCells + 2 * kTileOverlap;
  constexpr std::size_t kStride = kStrideUnit;  // 14 labels, or fewer
  return kCells * kCells * kCellPixels * kStride * (sizeof(std::uint8_t) + sizeof(std::uint16_t));
}

FloatImage match_level(const Level& level, const Labels& labels, SharedBudget& costs, const Run& run) {
  FloatImage result(labels.width, labels.height, 1, std::numeric_limits<float>::quiet_NaN());
  const Smoothness smoothness = smoothness_for(*level.image);
  const int across = (labels.columns + kTileCells - 1) / kTileCells, down = (labels.rows + kTileCells - 1) / kTileCells;
  parallel_for(run, std::size_t(across * down), [&](std::size_t i) {
    const int column = int(i) % across, row = int(i) / across;
    const CellRange tile{labels.columns * column / across, labels.rows * row / down,
                         labels.columns * (column + 1) / across, labels.rows * (row + 1) / down};
    match_tile(level, labels, smoothness, tile, costs, run, result);
  });
  return result;
}

}  // namespace collinea::dense
