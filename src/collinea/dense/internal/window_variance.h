// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

namespace collinea::dense {

/// The variance of value_at(i, j) over the window from x - reach, y - reach to x + reach, y + reach, as far as it lies
/// within width x height.
template <class Value>
[[nodiscard]] float variance_around(int x, int y, int reach, int width, int height, const Value& value_at) {
  float sum = 0, squares = 0;
  int count = 0;
  for (int j = std::max(y - reach, 0); j <= std::min(y + reach, height - 1); ++j)
    for (int i = std::max(x - reach, 0); i <= std::min(x + reach, width - 1); ++i, ++count) {
      const float value = value_at(i, j);
      sum += value;
      squares += value * value;
    }
  return std::max(0.0f, (squares - sum * sum / float(count)) / float(count));
}

}  // namespace collinea::dense
