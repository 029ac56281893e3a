// SPDX-License-Identifier: Apache-2.0
#include "collinea/assess/internal/rough_cells.h"

#include <algorithm>
#include <cmath>

namespace collinea {

Raster<std::uint8_t> rough_cells(const FloatImage& heights_m, double cell_m, int margin, double steepest) {
  Raster<std::uint8_t> steep(heights_m.width, heights_m.height), rows = steep, result = steep;
  const float most = float(steepest * cell_m);
  const auto mark = [&](int x, int y, int u, int v) {
    if (!(std::abs(heights_m.at(x, y) - heights_m.at(u, v)) <= most)) steep.at(x, y) = steep.at(u, v) = 1;
  };
  for (int y = 0; y < steep.height; ++y) {
    for (int x = 0; x < steep.width; ++x) {
      if (x + 1 < steep.width) mark(x, y, x + 1, y);
      if (y + 1 < steep.height) mark(x, y, x, y + 1);
    }
  }
  for (int y = 0; y < steep.height; ++y)
    for (int x = 0; x < steep.width; ++x)
      if (steep.at(x, y))
        std::fill(rows.row(y) + std::max(0, x - margin), rows.row(y) + std::min(steep.width, x + margin + 1),
                  std::uint8_t{1});
  for (int y = 0; y < steep.height; ++y)
    for (int v = std::max(0, y - margin); v <= std::min(steep.height - 1, y + margin); ++v)
      for (int x = 0; x < steep.width; ++x) result.at(x, y) |= rows.at(x, v);
  return result;
}

}  // namespace collinea
