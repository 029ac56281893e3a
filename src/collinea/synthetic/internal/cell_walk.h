// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <limits>

#include "collinea/synthetic/internal/noise.h"

namespace collinea {

/// Visits the cells of a grid that a line crosses, in order (Amanatides and Woo 1987). Everything is in units of cells;
/// the parameter t of the line is the caller's.
class CellWalk {
 public:
  /// The line (x, y) + t (dx, dy), from parameter `start` on, over a grid of `width` x `height` cells.
  CellWalk(double x, double y, double dx, double dy, double start, int width, int height)
      : column_(std::clamp(floor_int(x + start * dx), 0, width - 1)),
        row_(std::clamp(floor_int(y + start * dy), 0, height - 1)),
        width_(width),
        height_(height) {
    begin(x, dx, column_, step_column_, next_column_, delta_column_);
    begin(y, dy, row_, step_row_, next_row_, delta_row_);
  }

  [[nodiscard]] int column() const { return column_; }
  [[nodiscard]] int row() const { return row_; }
  /// The parameter at which the line leaves this cell.
  [[nodiscard]] double exit() const { return std::min(next_column_, next_row_); }
  /// Steps to the next cell; false: the line has left the grid.
  bool advance() {
    if (next_column_ < next_row_) {
      column_ += step_column_;
      next_column_ += delta_column_;
      return column_ >= 0 && column_ < width_;
    }
    row_ += step_row_;
    next_row_ += delta_row_;
    return row_ >= 0 && row_ < height_;
  }

 private:
  static void begin(double origin, double direction, int cell, int& step, double& next, double& delta) {
    constexpr double kNever = std::numeric_limits<double>::infinity();
    step = direction > 0 ? 1 : -1;
    const double inverse = 1 / direction;
    next = direction > 0 ? (cell + 1 - origin) * inverse : direction < 0 ? (cell - origin) * inverse : kNever;
    delta = direction > 0 ? inverse : direction < 0 ? -inverse : kNever;
  }

  int column_, row_, width_, height_, step_column_ = 1, step_row_ = 1;
  double next_column_ = 0, next_row_ = 0, delta_column_ = 0, delta_row_ = 0;
};

}  // namespace collinea
