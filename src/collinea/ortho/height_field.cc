// SPDX-License-Identifier: Apache-2.0
#include "collinea/ortho/height_field.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace collinea {
namespace {

constexpr float kNothing = -std::numeric_limits<float>::infinity();
constexpr double kMostUncertainCells = 10;
constexpr int kSide = HeightWindow::kCeilingReach;

FloatImage block_maxima(const FloatImage& heights_m) {
  FloatImage blocks((heights_m.width + kSide - 1) / kSide, (heights_m.height + kSide - 1) / kSide, 1, kNothing);
  for (int y = 0; y < heights_m.height; ++y) {
    const float* row = heights_m.row(y);
    float* block = blocks.row(y / kSide);
    for (int x = 0; x < heights_m.width; ++x)
      if (row[x] > block[x / kSide]) block[x / kSide] = row[x];  // false for NaN
  }
  return blocks;
}

// The lowest of the cells up to r rows and columns away.
FloatImage lowest_around(const FloatImage& heights_m, int r) {
  FloatImage rows = heights_m, result = heights_m;
  for (int y = 0; y < heights_m.height; ++y) {
    const float* from = heights_m.row(y);
    float* to = rows.row(y);
    for (int d = -r; d <= r; ++d)
      for (int x = std::max(0, -d); x < std::min(heights_m.width, heights_m.width - d); ++x)
        to[x] = std::min(to[x], from[x + d]);
  }
  for (int y = 0; y < heights_m.height; ++y) {
    float* to = result.row(y);
    for (int v = std::max(0, y - r); v <= std::min(heights_m.height - 1, y + r); ++v) {
      const float* from = rows.row(v);
      for (int x = 0; x < heights_m.width; ++x) to[x] = std::min(to[x], from[x]);
    }
  }
  return result;
}

FloatImage dilated(const FloatImage& blocks) {
  FloatImage result(blocks.width, blocks.height, 1, kNothing);
  for (int y = 0; y < blocks.height; ++y)
    for (int x = 0; x < blocks.width; ++x)
      for (int v = std::max(0, y - 1); v <= std::min(blocks.height - 1, y + 1); ++v)
        for (int u = std::max(0, x - 1); u <= std::min(blocks.width - 1, x + 1); ++u)
          result.at(x, y) = std::max(result.at(x, y), blocks.at(u, v));
  return result;
}

void add_strip(const FloatImage& strip, int first_row, HeightOverview& result) {
  constexpr int kBlock = HeightOverview::kBlock;
  const int block_row = first_row / kBlock;
  for (int block = 0; block < result.lowest_m.width; ++block) {
    float low = std::numeric_limits<float>::infinity(), high = kNothing;
    SurfacePlace place;
    int nearest = std::numeric_limits<int>::max();
    for (int y = 0; y < strip.height; ++y) {
      for (int x = block * kBlock; x < std::min((block + 1) * kBlock, strip.width); ++x) {
        const float z = strip.at(x, y);
        if (std::isnan(z)) continue;
        low = std::min(low, z), high = std::max(high, z);
        const int dx = x - block * kBlock - kBlock / 2, dy = y - kBlock / 2;
        if (dx * dx + dy * dy >= nearest) continue;
        nearest = dx * dx + dy * dy;
        place = {x + 0.5, first_row + y + 0.5, z};
      }
    }
    if (high == kNothing) continue;
    result.lowest_m.at(block, block_row) = low;
    result.highest_m.at(block, block_row) = high;
    result.places.push_back(place);
  }
}

using ReadHeights = std::function<Result<FloatImage>(int column, int row, int width, int height)>;

ReadHeights read_thinned(const ReadHeights& read, const MapGrid& grid, int times) {
  return [read, times, columns = grid.width, rows = grid.height](int column, int row, int width,
                                                                 int height) -> Result<FloatImage> {
    FloatImage result(width, height);
    const auto from = [times](int cell, int cells) { return std::min(cell * times + times / 2, cells - 1); };
    const int left = from(column, columns), right = from(column + width - 1, columns) + 1;
    constexpr int kStrip = 64;
    for (int strip = 0; strip < height; strip += kStrip) {
      const int end = std::min(strip + kStrip, height);
      const int top = from(row + strip, rows), bottom = from(row + end - 1, rows) + 1;
      COLLINEA_TRY(const FloatImage fine, read(left, top, right - left, bottom - top));
      for (int y = strip; y < end; ++y)
        for (int x = 0; x < width; ++x)
          result.at(x, y) = fine.at(from(column + x, columns) - left, from(row + y, rows) - top);
    }
    return result;
  };
}

}  // namespace

HeightField thinned(const HeightField& field, int times) {
  HeightField result;
  result.grid = field.grid;
  result.grid.cell_m *= times;
  result.grid.width = (field.grid.width + times - 1) / times;
  result.grid.height = (field.grid.height + times - 1) / times;
  result.read = read_thinned(field.read, field.grid, times);
  if (field.read_sigma) result.read_sigma = read_thinned(field.read_sigma, field.grid, times);
  return result;
}

Result<HeightOverview> overview(const HeightField& field, const Run& run) {
  constexpr int kBlock = HeightOverview::kBlock;
  const float none = std::numeric_limits<float>::quiet_NaN();
  HeightOverview result;
  result.lowest_m =
      FloatImage((field.grid.width + kBlock - 1) / kBlock, (field.grid.height + kBlock - 1) / kBlock, 1, none);
  result.highest_m = result.lowest_m;
  // Strips as high as a row of TIFF tiles, so that each tile is unpacked once.
  constexpr int kStrip = 8 * kBlock;
  for (int row = 0; row < field.grid.height; row += kStrip) {
    if (run.stopped()) return fail(Errc::kCancelled, "cancelled");
    COLLINEA_TRY(const FloatImage strip,
                 field.read(0, row, field.grid.width, std::min(kStrip, field.grid.height - row)));
    for (int part = 0; part < strip.height; part += kBlock) {
      FloatImage rows(strip.width, std::min(kBlock, strip.height - part));
      std::copy_n(strip.row(part), rows.data.size(), rows.data.begin());
      add_strip(rows, row + part, result);
    }
  }
  for (const SurfacePlace& place : result.places) result.mean_m += place.height_m;
  if (!result.places.empty()) result.mean_m /= double(result.places.size());
  return result;
}

HeightWindow::HeightWindow(FloatImage heights_m, int column, int row, double cell_m, const FloatImage& sigma_m)
    : heights_m_(std::move(heights_m)), column_(column), row_(row), cell_m_(cell_m) {
  // A surface of which next to nothing is known still hides: else what stands behind an unseen roof would be painted
  // with its walls.
  constexpr float kSigmas = 3;
  const auto most_m = float(kMostUncertainCells * cell_m);
  occluders_m_ = heights_m_;
  for (std::size_t i = 0; i < occluders_m_.data.size(); ++i) {
    float& z = occluders_m_.data[i];
    if (!sigma_m.empty()) z -= std::min(kSigmas * sigma_m.data[i], most_m);
    if (std::isnan(z)) z = kNothing;
  }
  wide_m_ = lowest_around(occluders_m_, kThin);
  const FloatImage blocks = block_maxima(occluders_m_);
  ceiling_m_ = dilated(blocks);
  highest_m_ = kNothing;
  for (const float z : blocks.data) highest_m_ = std::max(highest_m_, z);
}

float HeightWindow::at(double x, double y) const {
  const int column = int(std::floor(x)), row = int(std::floor(y));
  if (column < 0 || row < 0 || column >= heights_m_.width || row >= heights_m_.height)
    return std::numeric_limits<float>::quiet_NaN();
  const float nearest = heights_m_.at(column, row);
  const int x0 = int(std::floor(x - 0.5)), y0 = int(std::floor(y - 0.5));
  if (std::isnan(nearest) || x0 < 0 || y0 < 0 || x0 + 1 >= heights_m_.width || y0 + 1 >= heights_m_.height)
    return nearest;
  const float *upper = heights_m_.row(y0) + x0, *lower = heights_m_.row(y0 + 1) + x0;
  const float high = std::max(std::max(upper[0], upper[1]), std::max(lower[0], lower[1]));
  const float low = std::min(std::min(upper[0], upper[1]), std::min(lower[0], lower[1]));
  if (!(high - low <= 2 * cell_m_) || std::isnan(upper[0] + upper[1] + lower[0] + lower[1])) return nearest;
  const float a = float(x - 0.5 - x0), b = float(y - 0.5 - y0);
  return (1 - b) * ((1 - a) * upper[0] + a * upper[1]) + b * ((1 - a) * lower[0] + a * lower[1]);
}

float HeightWindow::ceiling_m(double x, double y) const {
  const int column = int(std::floor(x)) / kSide, row = int(std::floor(y)) / kSide;
  if (!(x >= 0) || !(y >= 0) || column >= ceiling_m_.width || row >= ceiling_m_.height) return highest_m_;
  return ceiling_m_.at(column, row);
}

bool HeightWindow::hides(const FloatImage& occluders_m, double x, double y, double height_m, double camera_x,
                         double camera_y, double camera_height_m) const {
  const double across = camera_x - x, down = camera_y - y, rise = camera_height_m - height_m;
  const double run = std::sqrt(across * across + down * down);
  if (!(rise > 0)) return true;
  if (run < 1) return false;
  const double step_x = across / run, step_y = down / run, rise_per_cell = rise / run;
  for (double s = 1.5; s < run;) {
    const double line_m = height_m + cell_m_ + rise_per_cell * s;
    if (line_m >= highest_m_) return false;
    const double u = x + s * step_x, v = y + s * step_y;
    if (!(u >= 0 && v >= 0 && u < heights_m_.width && v < heights_m_.height)) return false;
    const int column = int(u), row = int(v);
    if (ceiling_m_.at(column / kSide, row / kSide) <= line_m) {
      s += kCeilingReach;
      continue;
    }
    if (occluders_m.at(column, row) > line_m) return true;
    s += 0.75;
  }
  return false;
}

}  // namespace collinea
