// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/internal/octave_rows.h"

#include <cmath>
#include <cstring>
#include <utility>

#include "collinea/base/result.h"

namespace collinea {
namespace {

constexpr int kBandsBetweenMoves = 4;  // of the rows that are still needed to the front of a window

}  // namespace

RowWindow::RowWindow(int width, int height, int most_rows)
    : plane_(width, std::min(height, most_rows)), height_(height) {}

float* RowWindow::append() {
  if (end_ - first_ == plane_.height()) {
    COLLINEA_CHECK(needed_ > first_ && end_ < height_);
    const auto rows = static_cast<std::size_t>(std::max(0, end_ - needed_));
    std::memmove(plane_.row(0), plane_.row(needed_ - first_),
                 rows * static_cast<std::size_t>(plane_.stride()) * sizeof(float));
    first_ = needed_;
  }
  return plane_.row(end_++ - first_);
}

OctaveRows::OctaveRows(int width, int height, RowSource level0, const Bands& bands)
    : level0_(std::move(level0)), bands_(bands), height_(height) {
  for (int level = 1; level < bands.levels; ++level) {
    const double before = blur_of_level(level - 1), after = blur_of_level(level);
    filters_.emplace_back(width, height, std::sqrt(after * after - before * before));
  }
  int lag = 0;
  for (int level = bands.levels - 1; level >= 0; --level) {
    const bool is_kept = bands.are_kept && level >= 1 && level <= kSteps;
    const int most = kBandsBetweenMoves * bands.rows + 2 * bands.reach + lag;
    levels_[static_cast<std::size_t>(level)] = RowWindow(width, height, is_kept ? height : most);
    if (level > 0) lag += filters_[static_cast<std::size_t>(level) - 1].radius();
  }
}

bool OctaveRows::next() {
  if (end_ == height_) return false;
  begin_ = end_;
  end_ = std::min(height_, begin_ + bands_.rows);
  std::array<int, kLevels> ends{};
  int target = end_ + bands_.reach;
  for (int level = bands_.levels - 1; level >= 0; --level) {
    ends[static_cast<std::size_t>(level)] = std::min(height_, target);
    if (level > 0) target += filters_[static_cast<std::size_t>(level) - 1].radius();
  }
  for (std::size_t level = 0; level < static_cast<std::size_t>(bands_.levels); ++level) {
    RowWindow& rows = levels_[level];
    rows.need_from(std::max(0, begin_ - bands_.reach));
    while (rows.end() < ends[level]) {
      if (level == 0) {
        const int y = rows.end();
        level0_(y, rows.append());
        continue;
      }
      const RowWindow& before = levels_[level - 1];
      filters_[level - 1].next([&](int y, float* row) { std::copy_n(before.row(y), before.width(), row); },
                               rows.append());
    }
  }
  return true;
}

}  // namespace collinea
