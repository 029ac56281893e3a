// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "collinea/feature/internal/scale_space.h"

namespace collinea {

/// Rows of an image that come one after the other, upper first: the last ones, or all.
class RowWindow {
 public:
  RowWindow() = default;
  RowWindow(int width, int height, int most_rows);

  [[nodiscard]] int width() const { return plane_.width(); }
  [[nodiscard]] int height() const { return height_; }  ///< of the whole image
  [[nodiscard]] int end() const { return end_; }        ///< rows that have come
  [[nodiscard]] const float* row(int y) const { return plane_.row(y - first_); }
  [[nodiscard]] float at(int x, int y) const { return row(y)[x]; }
  [[nodiscard]] BlurredImage view() const { return {plane_.row(0), plane_.stride(), width(), height_, first_}; }

  /// The next row, to be written. Where there is no room, those above the first that is needed make it.
  float* append();
  void need_from(int y) { needed_ = std::max(needed_, y); }

 private:
  Plane plane_;
  int height_ = 0, first_ = 0, end_ = 0, needed_ = 0;
};

using Octave = std::array<RowWindow, kLevels>;

/// The levels of an octave, band by band from the top: a large image needs no more memory than some of its rows, and a
/// small one stays in the cache. Each row is the same whatever the bands are.
class OctaveRows {
 public:
  struct Bands {
    int rows = 64;
    int reach = 0;          ///< rows above and below a band that are needed with it
    int levels = kLevels;   ///< that are needed, from 0 on
    bool are_kept = false;  ///< all rows of levels 1 to kSteps; else those of the band
  };
  OctaveRows(int width, int height, RowSource level0, const Bands& bands);

  /// Goes on to the next band; false after the last one.
  bool next();
  [[nodiscard]] int begin() const { return begin_; }  ///< the rows of the band
  [[nodiscard]] int end() const { return end_; }
  [[nodiscard]] const Octave& levels() const { return levels_; }
  [[nodiscard]] Octave take_levels() && { return std::move(levels_); }

 private:
  RowSource level0_;
  Bands bands_;
  int height_, begin_ = 0, end_ = 0;
  Octave levels_;
  std::vector<RowFilter> filters_;  // from the level before to each, from level 1 on
};

}  // namespace collinea
