// SPDX-License-Identifier: Apache-2.0
#include "collinea/match/census.h"

#include <algorithm>

namespace collinea {

std::uint64_t darker_neighbours(const GreyImage& image, int column, int row, int half) {
  std::uint64_t bits = 0;
  const int grey = image.at(column, row);
  for (int y = row - half; y <= row + half; ++y) {
    const std::uint8_t* values = image.row(std::clamp(y, 0, image.height - 1));
    for (int x = column - half; x <= column + half; ++x)
      if (x != column || y != row) bits = bits << 1 | std::uint64_t(values[std::clamp(x, 0, image.width - 1)] < grey);
  }
  return bits;
}

}  // namespace collinea
