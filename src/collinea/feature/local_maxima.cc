// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/local_maxima.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <tuple>
#include <unordered_set>

namespace collinea {
namespace {

// Columns and rows around a pixel, within the map.
struct Window {
  int left, right, top, bottom;

  Window(const FloatImage& map, int column, int row, int radius)
      : left(std::max(0, column - radius)),
        right(std::min(map.width - 1, column + radius)),
        top(std::max(0, row - radius)),
        bottom(std::min(map.height - 1, row + radius)) {}
};

bool is_largest(const FloatImage& map, int column, int row, int radius) {
  const Window w(map, column, row, radius);
  const float value = map.at(column, row);
  for (int y = w.top; y <= w.bottom; ++y) {
    const float* at = map.row(y);
    for (int x = w.left; x <= w.right; ++x)
      if (at[x] > value) return false;
  }
  return true;
}

// The plateaus that were looked at, so that each is looked at once.
class Plateaus {
 public:
  explicit Plateaus(const FloatImage& map) : map_(map) {}

  /// The middle of the plateau with this pixel; nothing where a larger value touches it or it is known already.
  std::optional<MapPixel> middle(int column, int row) {
    if (is_known(column, row)) return std::nullopt;
    const float value = map_.at(column, row);
    std::vector<MapPixel> members = {{column, row, value}};
    bool is_higher_beside = false;
    known_.insert(key(column, row));
    for (std::size_t i = 0; i < members.size(); ++i) {
      const Window w(map_, members[i].column, members[i].row, 1);
      for (int y = w.top; y <= w.bottom; ++y)
        for (int x = w.left; x <= w.right; ++x) {
          is_higher_beside |= map_.at(x, y) > value;
          if (map_.at(x, y) == value && known_.insert(key(x, y)).second) members.push_back({x, y, value});
        }
    }
    if (is_higher_beside) return std::nullopt;
    return nearest_to_mean(members);
  }

 private:
  [[nodiscard]] std::uint64_t key(int column, int row) const {
    return static_cast<std::uint64_t>(row) * static_cast<std::uint64_t>(map_.width) +
           static_cast<std::uint64_t>(column);
  }
  [[nodiscard]] bool is_known(int column, int row) const { return known_.contains(key(column, row)); }

  static MapPixel nearest_to_mean(const std::vector<MapPixel>& members) {
    double x = 0, y = 0;
    for (const MapPixel& m : members) {
      x += m.column / static_cast<double>(members.size());
      y += m.row / static_cast<double>(members.size());
    }
    const auto order = [&](const MapPixel& m) {
      const double distance2 = (m.column - x) * (m.column - x) + (m.row - y) * (m.row - y);
      return std::tuple(std::round(distance2 * 1e6), m.row, m.column);  // rounded: equal distances stay equal
    };
    return *std::ranges::min_element(members, {}, order);
  }

  const FloatImage& map_;
  std::unordered_set<std::uint64_t> known_;
};

bool has_equal_neighbour(const FloatImage& map, int column, int row) {
  const Window w(map, column, row, 1);
  int equal = 0;
  for (int y = w.top; y <= w.bottom; ++y)
    for (int x = w.left; x <= w.right; ++x) equal += map.at(x, y) == map.at(column, row);
  return equal > 1;
}

// Equal maxima that are no neighbours may still lie within the radius; the first in the order stays.
std::vector<MapPixel> without_equals_nearby(const std::vector<MapPixel>& sorted, int radius) {
  std::map<std::pair<int, int>, std::vector<MapPixel>> cells;  // of the size of the radius
  std::vector<MapPixel> kept;
  for (const MapPixel& m : sorted) {
    const int column = m.column / std::max(1, radius), row = m.row / std::max(1, radius);
    bool is_alone = true;
    for (int y = row - 1; y <= row + 1; ++y)
      for (int x = column - 1; x <= column + 1; ++x)
        if (const auto cell = cells.find({x, y}); cell != cells.end())
          for (const MapPixel& other : cell->second)
            is_alone &= std::abs(other.column - m.column) > radius || std::abs(other.row - m.row) > radius;
    if (!is_alone) continue;
    kept.push_back(m);
    cells[{column, row}].push_back(m);
  }
  return kept;
}

}  // namespace

std::vector<MapPixel> local_maxima(const FloatImage& map, int radius_px, float threshold) {
  const int radius = std::max(1, radius_px);
  std::vector<MapPixel> found;
  Plateaus plateaus(map);
  for (int y = 0; y < map.height; ++y) {
    const float* row = map.row(y);
    for (int x = 0; x < map.width; ++x) {
      if (!(row[x] > threshold)) continue;
      if ((x > 0 && row[x - 1] > row[x]) || (x + 1 < map.width && row[x + 1] > row[x])) continue;
      if (!is_largest(map, x, y, radius)) continue;
      if (!has_equal_neighbour(map, x, y))
        found.push_back({x, y, row[x]});
      else if (const auto middle = plateaus.middle(x, y))
        found.push_back(*middle);
    }
  }
  std::ranges::sort(found, {}, [](const MapPixel& m) { return std::tuple(-m.value, m.row, m.column); });
  return without_equals_nearby(found, radius);
}

}  // namespace collinea
