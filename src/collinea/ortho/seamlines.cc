// SPDX-License-Identifier: Apache-2.0
#include "collinea/ortho/seamlines.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "collinea/geometry/polygon.h"

namespace collinea {
namespace {

// To the east, south, west and north.
const std::array<Eigen::Vector2i, 4> kStep = {
    {Eigen::Vector2i(1, 0), Eigen::Vector2i(0, 1), Eigen::Vector2i(-1, 0), Eigen::Vector2i(0, -1)}};

// Numbers the areas that hang together by sides, from 1 on in the order of their first cells.
Raster<std::int32_t> areas_of(const Raster<std::uint16_t>& source, std::vector<std::uint16_t>& sources) {
  Raster<std::int32_t> area(source.width, source.height);
  std::vector<std::pair<int, int>> left;
  for (int y = 0; y < source.height; ++y) {
    for (int x = 0; x < source.width; ++x) {
      if (source.at(x, y) == 0 || area.at(x, y) != 0) continue;
      sources.push_back(source.at(x, y));
      const auto number = std::int32_t(sources.size());
      area.at(x, y) = number;
      left.assign(1, {x, y});
      while (!left.empty()) {
        const auto [u, v] = left.back();
        left.pop_back();
        for (const auto& [i, j] :
             {std::pair(u + 1, v), std::pair(u, v + 1), std::pair(u - 1, v), std::pair(u, v - 1)}) {
          if (i < 0 || j < 0 || i >= source.width || j >= source.height) continue;
          if (source.at(i, j) != sources.back() || area.at(i, j) != 0) continue;
          area.at(i, j) = number;
          left.emplace_back(i, j);
        }
      }
    }
  }
  return area;
}

// Walks along the sides of cells, the area on the right hand.
class Tracer {
 public:
  explicit Tracer(const Raster<std::int32_t>& area) : area_(area), walked_(area.data.size()) {}

  // True where the upper side of a cell is a border that no ring has passed yet.
  [[nodiscard]] bool starts_at(int x, int y) const {
    return at(x, y) != 0 && at(x, y - 1) != at(x, y) && !walked_[cell(x, y)];
  }

  // Corners in cells, only where the direction changes.
  std::vector<Eigen::Vector2i> ring_from(int x, int y) {
    const std::int32_t own = at(x, y);
    std::vector<Eigen::Vector2i> corners;
    const Eigen::Vector2i start(x, y);
    Eigen::Vector2i corner = start;
    int heading = kEast;
    do {
      if (heading == kEast) walked_[cell(corner.x(), corner.y())] = true;
      corner += kStep[std::size_t(heading)];
      // Where two cells of the area meet in a corner only, the walk crosses over to the other: left first.
      int next = (heading + 3) % 4;
      while (!is_border(own, corner, next)) next = (next + 1) % 4;
      if (next != heading) corners.push_back(corner);
      heading = next;
    } while (corner != start || heading != kEast);
    return corners;
  }

 private:
  static constexpr int kEast = 0;  // then south, west, north
  [[nodiscard]] std::size_t cell(int x, int y) const {
    return std::size_t(y) * std::size_t(area_.width) + std::size_t(x);
  }
  [[nodiscard]] std::int32_t at(int x, int y) const {
    return x < 0 || y < 0 || x >= area_.width || y >= area_.height ? 0 : area_.at(x, y);
  }
  // The side that leads from a corner into a direction has the area on its right and something else on its left.
  [[nodiscard]] bool is_border(std::int32_t own, const Eigen::Vector2i& corner, int heading) const {
    const int x = corner.x(), y = corner.y();
    const std::array<std::int32_t, 4> around = {at(x, y), at(x - 1, y), at(x - 1, y - 1), at(x, y - 1)};
    return around[std::size_t(heading)] == own && around[std::size_t((heading + 3) % 4)] != own;
  }

  const Raster<std::int32_t>& area_;
  std::vector<bool> walked_;  // per cell
};

// Answers whether anything changed.
bool absorb_once(std::size_t fewest_cells, Raster<std::uint16_t>& source) {
  bool changed = false;
  std::vector<std::uint16_t> sources;
  const Raster<std::int32_t> area = areas_of(source, sources);
  std::vector<std::vector<Eigen::Vector2i>> cells(sources.size());
  for (int y = 0; y < source.height; ++y)
    for (int x = 0; x < source.width; ++x)
      if (area.at(x, y) != 0)
        if (auto& own = cells[std::size_t(area.at(x, y) - 1)]; own.size() < fewest_cells) own.emplace_back(x, y);
  for (const auto& own : cells) {
    if (own.size() >= fewest_cells) continue;
    std::map<std::uint16_t, int> borders;
    for (const Eigen::Vector2i& cell : own) {
      for (const auto& step : kStep) {
        const Eigen::Vector2i neighbour = cell + step;
        if (neighbour.x() < 0 || neighbour.y() < 0 || neighbour.x() >= source.width || neighbour.y() >= source.height)
          continue;
        if (area.at(neighbour.x(), neighbour.y()) == area.at(cell.x(), cell.y())) continue;
        if (const std::uint16_t other = source.at(neighbour.x(), neighbour.y()); other != 0) ++borders[other];
      }
    }
    const auto longest = std::max_element(borders.begin(), borders.end(),
                                          [](const auto& a, const auto& b) { return a.second < b.second; });
    if (longest == borders.end()) continue;
    for (const Eigen::Vector2i& cell : own) source.at(cell.x(), cell.y()) = longest->first;
    changed = true;
  }
  return changed;
}

}  // namespace

// Small areas that touch take each other's source: what is small still goes in the next round.
void absorb_small_areas(std::size_t fewest_cells, Raster<std::uint16_t>& source) {
  constexpr int kRounds = 8;
  for (int round = 0; round < kRounds && absorb_once(fewest_cells, source); ++round) {
  }
}

std::vector<SeamPolygon> outlines_of(const Raster<std::uint16_t>& source, const MapGrid& grid) {
  std::vector<std::uint16_t> sources;
  const Raster<std::int32_t> area = areas_of(source, sources);
  std::vector<SeamPolygon> polygons(sources.size());
  for (std::size_t i = 0; i < sources.size(); ++i) polygons[i].source = sources[i];
  Tracer tracer(area);
  for (int y = 0; y < source.height; ++y) {
    for (int x = 0; x < source.width; ++x) {
      if (!tracer.starts_at(x, y)) continue;
      MapRing ring;
      for (const Eigen::Vector2i& corner : tracer.ring_from(x, y))
        ring.emplace_back(grid.east_of(corner.x()), grid.north_of(corner.y()));
      // The first cell of an area lies on its outline, which therefore comes before its holes.
      polygons[std::size_t(area.at(x, y) - 1)].rings.push_back(std::move(ring));
    }
  }
  return polygons;
}

namespace {

// Where the border of a polygon crosses the middles of rows: in columns, centres of cells from here on.
void find_crossings(const SeamPolygon& polygon, const MapGrid& grid, int column, int row,
                    std::vector<std::vector<double>>& crossings) {
  const double rows = double(crossings.size());
  for (const MapRing& ring : polygon.rings)
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const Eigen::Vector2d &a = ring[i], &b = ring[i + 1 < ring.size() ? i + 1 : 0];
      const double first = grid.row_of(std::max(a.y(), b.y())) - row - 1;
      const double last = grid.row_of(std::min(a.y(), b.y())) - row + 1;
      for (int y = int(std::clamp(std::floor(first), 0.0, rows)); y < int(std::clamp(std::ceil(last), 0.0, rows));
           ++y) {
        const double north_m = grid.north_of(row + y + 0.5);
        if (const auto east_m = crossing(a, b, north_m))
          crossings[std::size_t(y)].push_back(grid.column_of(*east_m) - column - 0.5);
      }
    }
}

}  // namespace

void fill(const std::vector<SeamPolygon>& polygons, const MapGrid& grid, int column, int row,
          Raster<std::uint16_t>& source, Raster<std::uint16_t>& below) {
  const double west_m = grid.east_of(column), east_m = grid.east_of(column + source.width);
  const double north_m = grid.north_of(row), south_m = grid.north_of(row + source.height);
  std::vector<std::vector<double>> crossings(std::size_t(source.height));
  for (const SeamPolygon& polygon : polygons) {
    MapRing corners;  // of the rectangle around it
    for (const MapRing& ring : polygon.rings)
      for (const auto& corner : ring) {
        if (corners.empty()) corners = {corner, corner};
        corners = {corners[0].cwiseMin(corner), corners[1].cwiseMax(corner)};
      }
    if (corners.empty() || corners[1].x() < west_m || corners[0].x() > east_m || corners[1].y() < south_m ||
        corners[0].y() > north_m)
      continue;
    for (auto& of_row : crossings) of_row.clear();
    find_crossings(polygon, grid, column, row, crossings);
    for (int y = 0; y < source.height; ++y) {
      std::vector<double>& at = crossings[std::size_t(y)];
      std::sort(at.begin(), at.end());
      for (std::size_t i = 0; i + 1 < at.size(); i += 2) {
        const int begin = int(std::clamp(std::ceil(at[i]), 0.0, double(source.width)));
        const int end = int(std::clamp(std::ceil(at[i + 1]), 0.0, double(source.width)));
        for (int x = begin; x < end; ++x) {
          if (source.at(x, y) != polygon.source) below.at(x, y) = source.at(x, y);
          source.at(x, y) = polygon.source;
        }
      }
    }
  }
}

}  // namespace collinea
