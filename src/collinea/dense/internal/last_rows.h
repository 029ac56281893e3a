// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <vector>

#include "collinea/dense/internal/measure_kernels.h"

namespace collinea::dense {

/// The last `count` rows of an image, which can be read and written some columns beyond their ends.
class LastRows {
 public:
  /// All of it is `value`, also beyond the ends.
  LastRows(int width, int count, float value)
      : width_(width),
        count_(count),
        stride_(width + 2 * kBorder + kRowSlack),
        data_(std::size_t(stride_) * std::size_t(count), value) {}

  [[nodiscard]] float* row(int y) { return data_.data() + std::size_t(y % count_) * std::size_t(stride_) + kBorder; }

  void repeat_border(int y) {
    float* values = row(y);
    std::fill(values - kBorder, values, values[0]);
    std::fill(values + width_, values + width_ + kBorder + kRowSlack, values[width_ - 1]);
  }

 private:
  static constexpr int kBorder = 4;  // columns on either side of a row
  int width_, count_, stride_;
  std::vector<float> data_;
};

}  // namespace collinea::dense
