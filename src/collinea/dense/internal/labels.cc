// SPDX-License-Identifier: Apache-2.0
#include "collinea/dense/internal/labels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "collinea/dense/internal/last_rows.h"
#include "collinea/dense/internal/measure_kernels.h"
#include "collinea/math/median.h"

namespace collinea::dense {
namespace {

constexpr float kLargestSlope = 1.5f;  // steps per pixel; a surface steeper than this counts as broken

void set_labels(Cell& cell, float low, float high) {
  cell.labels = std::clamp(int(std::ceil(high - low)) + 1, 3, kMaxLabels);
  const float middle = (low + high) / 2;
  cell.first = std::round(middle - float(cell.labels - 1) / 2);
  cell.stride = (cell.labels + 2 * kGuard + kStrideUnit - 1) / kStrideUnit * kStrideUnit;
}

Labels empty_labels(int width, int height, float step) {
  Labels labels;
  labels.width = width;
  labels.height = height;
  labels.columns = (width + kCell - 1) / kCell;
  labels.rows = (height + kCell - 1) / kCell;
  labels.step = step;
  labels.cells.resize(std::size_t(labels.columns) * std::size_t(labels.rows));
  for (int j = 0; j < labels.rows; ++j)
    for (int i = 0; i < labels.columns; ++i) {
      Cell& cell = labels.cells[std::size_t(j) * std::size_t(labels.columns) + std::size_t(i)];
      cell.left = i * kCell;
      cell.top = j * kCell;
    }
  return labels;
}

// Mean of 3 x 3, weights 1 2 1.
FloatImage smoothed(const FloatImage& raster) {
  FloatImage across(raster.width, raster.height), result(raster.width, raster.height);
  for (int y = 0; y < raster.height; ++y)
    for (int x = 0; x < raster.width; ++x)
      across.at(x, y) = 0.25f * raster.at(std::max(x - 1, 0), y) + 0.5f * raster.at(x, y) +
                        0.25f * raster.at(std::min(x + 1, raster.width - 1), y);
  for (int y = 0; y < raster.height; ++y)
    for (int x = 0; x < raster.width; ++x)
      result.at(x, y) = 0.25f * across.at(x, std::max(y - 1, 0)) + 0.5f * across.at(x, y) +
                        0.25f * across.at(x, std::min(y + 1, raster.height - 1));
  return result;
}

FloatImage doubled(const FloatImage& raster, int width, int height) {
  FloatImage result(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) result.at(x, y) = bilinear(raster, (x + 0.5) / 2, (y + 0.5) / 2);
  return result;
}

struct Footprint {
  int x0, y0, x1, y1;  // pixels of the coarse image, ends excluded
};

Footprint footprint(const Cell& cell, const FloatImage& coarse) {
  constexpr int kAround = 2;  // coarse pixels: edges of objects may have been found that far off
  return {std::clamp(cell.left / 2 - kAround, 0, coarse.width - 1),
          std::clamp(cell.top / 2 - kAround, 0, coarse.height - 1),
          std::min((cell.left + kCell) / 2 + kAround, coarse.width),
          std::min((cell.top + kCell) / 2 + kAround, coarse.height)};
}

bool is_broken(const FloatImage& coarse, const Footprint& at, float step) {
  const float limit = 2 * kLargestSlope * step;  // a coarse pixel is two fine ones
  for (int y = at.y0; y < at.y1; ++y)
    for (int x = at.x0; x < at.x1; ++x) {
      if (x + 1 < at.x1 && std::abs(coarse.at(x + 1, y) - coarse.at(x, y)) > limit) return true;
      if (y + 1 < at.y1 && std::abs(coarse.at(x, y + 1) - coarse.at(x, y)) > limit) return true;
    }
  return false;
}

// The slope most of the cell has, and the range of what is off the plane with that slope.
void follow_plane(const FloatImage& coarse, const Footprint& at, float step, int margin, Cell& cell) {
  std::vector<float> by_x, by_y;
  for (int y = at.y0; y < at.y1; ++y)
    for (int x = at.x0; x < at.x1; ++x) {
      if (x + 1 < at.x1) by_x.push_back(coarse.at(x + 1, y) - coarse.at(x, y));
      if (y + 1 < at.y1) by_y.push_back(coarse.at(x, y + 1) - coarse.at(x, y));
    }
  cell.by_x = by_x.empty() ? 0 : median(by_x) / 2;
  cell.by_y = by_y.empty() ? 0 : median(by_y) / 2;
  std::vector<float> rest;
  for (int y = at.y0; y < at.y1; ++y)
    for (int x = at.x0; x < at.x1; ++x)
      rest.push_back(coarse.at(x, y) - cell.by_x * (2 * float(x) + 0.5f - float(cell.left)) -
                     cell.by_y * (2 * float(y) + 0.5f - float(cell.top)));
  std::sort(rest.begin(), rest.end());
  float low = rest.front(), high = rest.back();
  // too far apart to search everything between: leave out the rarest
  for (std::size_t cut = 1; (high - low) / step > float(kMaxLabels - 2 * margin - 1) && 2 * cut < rest.size(); ++cut) {
    low = rest[cut];
    high = rest[rest.size() - 1 - cut];
  }
  cell.at_corner = low;
  set_labels(cell, -float(margin), (high - low) / step + float(margin));
}

void follow_surface(const FloatImage& coarse, const FloatImage& smooth, const Footprint& at, float step, int margin,
                    Cell& cell) {
  cell.follows_surface = true;
  float off = 0;
  for (int y = at.y0; y < at.y1; ++y)
    for (int x = at.x0; x < at.x1; ++x) off = std::max(off, std::abs(coarse.at(x, y) - smooth.at(x, y)));
  const float reach = float(margin) + off / step;
  set_labels(cell, -reach, reach);
}

}  // namespace

float Labels::base(const Cell& cell, int x, int y) const {
  if (cell.follows_surface) return surface.at(std::clamp(x, 0, width - 1), std::clamp(y, 0, height - 1));
  return cell.at_corner + cell.by_x * float(x - cell.left) + cell.by_y * float(y - cell.top);
}

Labels labels_around_plane(int width, int height, float step, float at_corner, float by_x, float by_y, float low,
                           float high) {
  Labels labels = empty_labels(width, height, step);
  for (Cell& cell : labels.cells) {
    cell.at_corner = at_corner + by_x * float(cell.left) + by_y * float(cell.top);
    cell.by_x = by_x;
    cell.by_y = by_y;
    set_labels(cell, low, high);
  }
  return labels;
}

Labels labels_around(const FloatImage& coarse, int width, int height, float step, int margin) {
  Labels labels = empty_labels(width, height, step);
  const FloatImage smooth = smoothed(coarse);
  labels.surface = doubled(smooth, width, height);
  for (Cell& cell : labels.cells) {
    const Footprint at = footprint(cell, coarse);
    if (is_broken(coarse, at, step))
      follow_plane(coarse, at, step, margin, cell);
    else
      follow_surface(coarse, smooth, at, step, margin, cell);
  }
  return labels;
}

FloatImage median3(const FloatImage& raster) {
  const int width = raster.width, height = raster.height;
  constexpr float kNothing = std::numeric_limits<float>::quiet_NaN();
  LastRows rows(width, 4, kNothing), beyond(width, 1, kNothing);
  std::vector<float> median(std::size_t(width + kRowSlack));
  FloatImage result(width, height);
  for (int y = 0; y <= height; ++y) {
    if (y < height) std::copy_n(raster.row(y), width, rows.row(y));
    if (y == 0) continue;
    median_of_known_row(
        {y > 1 ? rows.row(y - 2) : beyond.row(0), rows.row(y - 1), y < height ? rows.row(y) : beyond.row(0)}, width,
        median.data());
    std::copy_n(median.begin(), width, result.row(y - 1));
  }
  return result;
}

FloatImage halved(const FloatImage& raster) {
  FloatImage half((raster.width + 1) / 2, (raster.height + 1) / 2);
  for (int y = 0; y < half.height; ++y)
    for (int x = 0; x < half.width; ++x) {
      float sum = 0;
      int count = 0;
      for (int j = 2 * y; j < std::min(2 * y + 2, raster.height); ++j)
        for (int i = 2 * x; i < std::min(2 * x + 2, raster.width); ++i)
          if (const float value = raster.at(i, j); !std::isnan(value)) sum += value, ++count;
      half.at(x, y) = count ? sum / float(count) : std::numeric_limits<float>::quiet_NaN();
    }
  return half;
}

// From halvings without holes, larger and larger, back to the full size.
void fill_holes(FloatImage& raster) {
  const auto is_hole = [](float value) { return std::isnan(value); };
  if (std::none_of(raster.data.begin(), raster.data.end(), is_hole)) return;
  if (raster.width <= 1 && raster.height <= 1) {
    for (float& value : raster.data) value = 0;
    return;
  }
  FloatImage coarse = halved(raster);
  fill_holes(coarse);
  for (int y = 0; y < raster.height; ++y)
    for (int x = 0; x < raster.width; ++x)
      if (is_hole(raster.at(x, y))) raster.at(x, y) = bilinear(coarse, (x + 0.5) / 2, (y + 0.5) / 2);
}

}  // namespace collinea::dense
