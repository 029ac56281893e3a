// SPDX-License-Identifier: Apache-2.0
#include "collinea/restitution/moved_edges.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace collinea {
namespace {

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

// 1 where a cell and its right or lower neighbour make a wall.
FloatImage walls_of(const FloatImage& heights, double least_m) {
  FloatImage walls(heights.width, heights.height, 1, 0);
  for (int y = 0; y < heights.height; ++y)
    for (int x = 0; x < heights.width; ++x) {
      const float here = heights.at(x, y);
      const float right = x + 1 < heights.width ? heights.at(x + 1, y) : here;
      const float below = y + 1 < heights.height ? heights.at(x, y + 1) : here;
      if (std::abs(right - here) > least_m || std::abs(below - here) > least_m) walls.at(x, y) = 1;
    }
  return walls;
}

// The highest value within reach along one axis; cells without a value take no part.
FloatImage highest_along(const FloatImage& image, bool along_x) {
  FloatImage out(image.width, image.height, 1, kNone);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      for (int k = -kEdgeReach; k <= kEdgeReach; ++k) {
        const int u = along_x ? x + k : x, v = along_x ? y : y + k;
        if (u < 0 || v < 0 || u >= image.width || v >= image.height || std::isnan(image.at(u, v))) continue;
        float& best = out.at(x, y);
        if (std::isnan(best) || image.at(u, v) > best) best = image.at(u, v);
      }
  return out;
}

FloatImage highest_in_reach(const FloatImage& image) { return highest_along(highest_along(image, true), false); }

FloatImage negated(FloatImage image) {
  for (float& value : image.data) value = -value;
  return image;
}

}  // namespace

HeightField moved_edges(const HeightField& field, bool outwards) {
  HeightField moved{.grid = field.grid, .read = {}, .read_sigma = field.read_sigma};
  moved.read = [&field, outwards](int column, int row, int width, int height) -> Result<FloatImage> {
    const int left = std::max(0, column - kEdgeReach), top = std::max(0, row - kEdgeReach);
    const int right = std::min(field.grid.width, column + width + kEdgeReach),
              bottom = std::min(field.grid.height, row + height + kEdgeReach);
    COLLINEA_TRY(const FloatImage around, field.read(left, top, right - left, bottom - top));
    const FloatImage is_near = highest_in_reach(walls_of(around, kWallSlope * field.grid.cell_m));
    const FloatImage edge = outwards ? highest_in_reach(around) : negated(highest_in_reach(negated(around)));
    FloatImage out(width, height, 1);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        const int u = x + column - left, v = y + row - top;
        const float here = around.at(u, v);
        out.at(x, y) = !std::isnan(here) && is_near.at(u, v) > 0 ? edge.at(u, v) : here;
      }
    return out;
  };
  return moved;
}

}  // namespace collinea
