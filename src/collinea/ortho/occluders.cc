// SPDX-License-Identifier: Apache-2.0
#include "collinea/ortho/occluders.h"

#include <algorithm>
#include <cmath>

namespace collinea {
namespace {

constexpr float kNothing = -std::numeric_limits<float>::infinity();
constexpr int kSide = Occluders::kCeilingReach;
constexpr int kBlock = HeightOverview::kBlock;
constexpr int kPerSide = kBlock / Occluders::kCoarse;  // coarse cells of a block
static_assert(kBlock % kSide == 0 && kBlock % Occluders::kCoarse == 0);

// Lines of sight are looked at always at the same distances from the point [cells], multiples of the steps: what is
// skipped makes no difference.
constexpr double kFirst = 1.5, kStep = 0.75, kFarFirst = 258, kFarStep = 3;
constexpr double kSkip = 15;  // within the reach of a ceiling
static_assert(kSkip <= kSide && kFarStep <= Occluders::kCoarse && kFarFirst - kFarStep <= Occluders::kNear);

// A surface of which next to nothing is known still hides: else what stands behind an unseen roof would be painted with
// its walls.
void take_sigmas_off(const FloatImage& sigma_m, double cell_m, float* heights_m) {
  constexpr float kSigmas = 3;
  constexpr double kMostUncertainCells = 10;
  const auto most_m = float(kMostUncertainCells * cell_m);
  for (std::size_t i = 0; i < sigma_m.data.size(); ++i) heights_m[i] -= std::min(kSigmas * sigma_m.data[i], most_m);
}

void clear_unknown(FloatImage& occluders_m) {
  for (float& z : occluders_m.data)
    if (std::isnan(z)) z = kNothing;
}

// The lowest of the cells up to r rows and columns away.
FloatImage lowest_around(const FloatImage& heights_m, int r) {
  const int width = heights_m.width, height = heights_m.height;
  FloatImage result(width, height);
  FloatImage rows(width, 2 * r + 1);  // the lowest of the cells beside, of the last few rows
  for (int y = 0; y < height + r; ++y) {
    if (y < height) {
      const float* from = heights_m.row(y);
      float* to = rows.row(y % rows.height);
      std::copy_n(from, width, to);
      for (int d = -r; d <= r; ++d)
        for (int x = std::max(0, -d); x < std::min(width, width - d); ++x) to[x] = std::min(to[x], from[x + d]);
    }
    if (y < r) continue;
    float* to = result.row(y - r);
    std::fill_n(to, width, std::numeric_limits<float>::infinity());
    for (int v = std::max(0, y - 2 * r); v <= std::min(height - 1, y); ++v) {
      const float* from = rows.row(v % rows.height);
      for (int x = 0; x < width; ++x) to[x] = std::min(to[x], from[x]);
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

// Heights of an area of the field, no higher than they certainly are.
Result<FloatImage> certain_heights(const HeightField& field, const CellArea& area) {
  COLLINEA_TRY(FloatImage heights_m, field.read(area.column, area.row, area.width, area.height));
  if (field.read_sigma) {
    COLLINEA_TRY(const FloatImage sigma_m, field.read_sigma(area.column, area.row, area.width, area.height));
    take_sigmas_off(sigma_m, field.grid.cell_m, heights_m.data.data());
  }
  clear_unknown(heights_m);
  return heights_m;
}

// The highest of the cells of a block that begins at (column, row) of `heights_m`, in coarse cells.
void append_coarse(const FloatImage& heights_m, int column, int row, std::vector<float>& cells) {
  const std::size_t first = cells.size();
  cells.resize(first + kPerSide * kPerSide, kNothing);
  for (int y = row; y < std::min(row + kBlock, heights_m.height); ++y) {
    float* to = cells.data() + first + (y - row) / Occluders::kCoarse * kPerSide;
    for (int x = column; x < std::min(column + kBlock, heights_m.width); ++x)
      to[(x - column) / Occluders::kCoarse] = std::max(to[(x - column) / Occluders::kCoarse], heights_m.at(x, y));
  }
}

}  // namespace

Occluders::Occluders(FloatImage heights_m, int column, int row, double cell_m, const FloatImage& sigma_m) {
  const CellArea near{column, row, heights_m.width, heights_m.height};
  take_sigmas_off(sigma_m, cell_m, heights_m.data.data());
  hold(std::move(heights_m), near, cell_m);
  finish_ceilings();
}

void Occluders::hold(FloatImage near_m, const CellArea& near, double cell_m) {
  column_ = near.column, row_ = near.row, cell_m_ = cell_m;
  all_ = near;
  near_m_ = std::move(near_m);
  clear_unknown(near_m_);
  ceiling_m_ = FloatImage((near.width + kSide - 1) / kSide, (near.height + kSide - 1) / kSide, 1, kNothing);
  add_ceilings(near_m_, column_, row_);
}

// The upper-left cell of what is added is the first of a block of ceilings.
void Occluders::add_ceilings(const FloatImage& occluders_m, int column, int row) {
  for (int y = 0; y < occluders_m.height; ++y) {
    const float* from = occluders_m.row(y);
    float* to = ceiling_m_.row((row - all_.row + y) / kSide) + (column - all_.column) / kSide;
    for (int x = 0; x < occluders_m.width; ++x) to[x / kSide] = std::max(to[x / kSide], from[x]);
  }
}

void Occluders::finish_ceilings() {
  for (const float z : ceiling_m_.data) highest_m_ = std::max(highest_m_, z);
  ceiling_m_ = dilated(ceiling_m_);
}

Result<> Occluders::look_further(const HeightField& field, const SurfaceBlocks& far) {
  const int left = std::min(column_ / kBlock, far.column), top = std::min(row_ / kBlock, far.row);
  const int right = std::clamp((far.column + far.wanted.width) * kBlock, column_ + near_m_.width, field.grid.width);
  const int bottom = std::clamp((far.row + far.wanted.height) * kBlock, row_ + near_m_.height, field.grid.height);
  all_ = {left * kBlock, top * kBlock, right - left * kBlock, bottom - top * kBlock};
  ceiling_m_ = FloatImage((all_.width + kSide - 1) / kSide, (all_.height + kSide - 1) / kSide, 1, kNothing);
  add_ceilings(near_m_, column_, row_);
  far_block_ = Raster<std::int32_t>((all_.width + kBlock - 1) / kBlock, (all_.height + kBlock - 1) / kBlock, 1, -1);
  // Pieces as large as the tiles of a raster file: each is unpacked once.
  constexpr int kPiece = 512 / kBlock;
  for (int y = far.row / kPiece * kPiece; y < far.row + far.wanted.height; y += kPiece) {
    for (int x = far.column / kPiece * kPiece; x < far.column + far.wanted.width; x += kPiece) {
      const int first_x = std::max(x, far.column), first_y = std::max(y, far.row);
      const int end_x = std::min(x + kPiece, far.column + far.wanted.width),
                end_y = std::min(y + kPiece, far.row + far.wanted.height);
      COLLINEA_TRY(add_far_blocks(field, {first_x, first_y, end_x - first_x, end_y - first_y}, far));
    }
  }
  return {};
}

Result<> Occluders::add_far_blocks(const HeightField& field, const CellArea& blocks, const SurfaceBlocks& far) {
  int left = blocks.column + blocks.width, right = -1, top = blocks.row + blocks.height, bottom = -1;  // of the wanted
  for (int y = blocks.row; y < blocks.row + blocks.height; ++y) {
    for (int x = blocks.column; x < blocks.column + blocks.width; ++x) {
      if (!far.wanted.at(x - far.column, y - far.row)) continue;
      left = std::min(left, x), right = std::max(right, x), top = std::min(top, y), bottom = std::max(bottom, y);
    }
  }
  if (right < 0) return {};
  const int first_column = std::max(0, left * kBlock - kThin), first_row = std::max(0, top * kBlock - kThin);
  const int end_column = std::min((right + 1) * kBlock + kThin, field.grid.width);
  const int end_row = std::min((bottom + 1) * kBlock + kThin, field.grid.height);
  COLLINEA_TRY(const FloatImage heights_m,
               certain_heights(field, {first_column, first_row, end_column - first_column, end_row - first_row}));
  const FloatImage wide_m = lowest_around(heights_m, kThin);
  for (int y = top; y <= bottom; ++y) {
    for (int x = left; x <= right; ++x) {
      if (!far.wanted.at(x - far.column, y - far.row)) continue;
      const std::size_t first = far_m_.size();
      append_coarse(heights_m, x * kBlock - first_column, y * kBlock - first_row, far_m_);
      append_coarse(wide_m, x * kBlock - first_column, y * kBlock - first_row, far_wide_m_);
      far_block_.at(x - all_.column / kBlock, y - all_.row / kBlock) = std::int32_t(first / (kPerSide * kPerSide));
      for (int cell = 0; cell < kPerSide * kPerSide; ++cell) {
        const int u = (x * kBlock - all_.column + cell % kPerSide * kCoarse) / kSide;
        const int v = (y * kBlock - all_.row + cell / kPerSide * kCoarse) / kSide;
        if (u >= ceiling_m_.width || v >= ceiling_m_.height) continue;  // beyond the raster, where nothing is
        ceiling_m_.at(u, v) = std::max(ceiling_m_.at(u, v), far_m_[first + std::size_t(cell)]);
      }
    }
  }
  return {};
}

Result<Occluders> occluders_of(const HeightField& field, FloatImage near_heights_m, const CellArea& near,
                               const SurfaceBlocks& far) {
  COLLINEA_CHECK(near.column % kSide == 0 && near.row % kSide == 0);
  constexpr int kStrip = 256;
  for (int row = 0; field.read_sigma && row < near.height; row += kStrip) {
    COLLINEA_TRY(const FloatImage sigma_m,
                 field.read_sigma(near.column, near.row + row, near.width, std::min(kStrip, near.height - row)));
    take_sigmas_off(sigma_m, field.grid.cell_m, near_heights_m.row(row));
  }
  Occluders occluders;
  occluders.hold(std::move(near_heights_m), near, field.grid.cell_m);
  if (!far.wanted.empty()) COLLINEA_TRY(occluders.look_further(field, far));
  occluders.finish_ceilings();
  return occluders;
}

float Occluders::ceiling_m(double x, double y) const {
  if (ceiling_m_.empty()) return highest_m_;
  const double u = std::clamp(x + (column_ - all_.column), 0.0, all_.width - 1.0);
  const double v = std::clamp(y + (row_ - all_.row), 0.0, all_.height - 1.0);
  return ceiling_m_.at(int(u) / kSide, int(v) / kSide);
}

bool Occluders::all_around_above(int column, int row, double line_m) const {
  const int left = std::max(0, column - kThin), right = std::min(near_m_.width - 1, column + kThin);
  for (int v = std::max(0, row - kThin); v <= std::min(near_m_.height - 1, row + kThin); ++v)
    for (int u = left; u <= right; ++u)
      if (!(near_m_.at(u, v) > line_m)) return false;
  return true;
}

template <bool wide_ones>
bool Occluders::hide(double x, double y, double height_m, double camera_x, double camera_y,
                     double camera_height_m) const {
  const double across = camera_x - x, down = camera_y - y, rise = camera_height_m - height_m;
  const double run = std::sqrt(across * across + down * down);
  if (!(rise > 0)) return true;
  if (run < 1) return false;
  const double step_x = across / run, step_y = down / run, rise_per_cell = rise / run;
  const int near_x = column_ - all_.column, near_y = row_ - all_.row;
  const double first_x = x + near_x, first_y = y + near_y, first_m = height_m + cell_m_;
  enum Meets { kPassesAll, kPassesSkipping, kPasses, kHidden };
  const auto look = [&](double s, const auto& reaches) {
    const double line_m = first_m + rise_per_cell * s;
    const double u = first_x + s * step_x, v = first_y + s * step_y;
    if (line_m >= highest_m_ || !(u >= 0 && v >= 0 && u < all_.width && v < all_.height)) return kPassesAll;
    const auto column = unsigned(u), row = unsigned(v);
    if (ceiling_m_.at(int(column / kSide), int(row / kSide)) <= line_m) return kPassesSkipping;
    return reaches(int(column), int(row), line_m) ? kHidden : kPasses;
  };
  const double near_run = far_block_.empty() ? run : std::min(run, kFarFirst);
  double s = kFirst;
  while (s < near_run) {
    const Meets met = look(s, [&](int column, int row, double line_m) {
      return near_m_.at(column - near_x, row - near_y) > line_m &&
             (!wide_ones || all_around_above(column - near_x, row - near_y, line_m));
    });
    if (met == kPassesAll || met == kHidden) return met == kHidden;
    s += met == kPasses ? kStep : kSkip;
  }
  s = std::ceil(s / kFarStep) * kFarStep;
  while (s < run) {
    const Meets met = look(s, [&](int column, int row, double line_m) {
      return far_at(wide_ones ? far_wide_m_ : far_m_, unsigned(column), unsigned(row)) > line_m;
    });
    if (met == kPassesAll || met == kHidden) return met == kHidden;
    s += met == kPasses ? kFarStep : kSkip;
  }
  return false;
}

template bool Occluders::hide<false>(double, double, double, double, double, double) const;
template bool Occluders::hide<true>(double, double, double, double, double, double) const;

float Occluders::far_at(const std::vector<float>& far_m, unsigned column, unsigned row) const {
  const std::int32_t block = far_block_.at(int(column / kBlock), int(row / kBlock));
  const unsigned cell = row % kBlock / kCoarse * kPerSide + column % kBlock / kCoarse;
  return block < 0 ? kNothing : far_m[std::size_t(block) * kPerSide * kPerSide + cell];
}

}  // namespace collinea
