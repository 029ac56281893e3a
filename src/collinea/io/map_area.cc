// SPDX-License-Identifier: Apache-2.0
#include "collinea/io/map_area.h"

#include <cmath>

#include "collinea/io/text.h"

namespace collinea {

double size_m2(const MapArea& area) {
  double twice = 0;
  for (std::size_t i = 0; i < area.size(); ++i) {
    const Eigen::Vector2d a = area[i] - area[0], b = area[(i + 1) % area.size()] - area[0];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return std::abs(twice) / 2;
}

Result<std::vector<Eigen::Vector2d>> parse_map_points(const std::string& text) {
  std::vector<Eigen::Vector2d> positions;
  const auto lines = lines_of(text);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const std::string_view line = trimmed(lines[i].substr(0, lines[i].find('#')));
    if (line.empty()) continue;
    const auto fields = line.find(',') != std::string_view::npos ? fields_of(line, ',') : words_of(line);
    const auto east = fields.size() > 1 ? number(fields[0]) : std::nullopt;
    const auto north = fields.size() > 1 ? number(fields[1]) : std::nullopt;
    if (east && north && std::isfinite(*east) && std::isfinite(*north)) {
      positions.emplace_back(*east, *north);
    } else if (!positions.empty() || east || north || fields.size() < 2) {
      return fail(Errc::kBadFormat, "line " + std::to_string(i + 1) + ": not a corner: easting, northing");
    }
  }
  return positions;
}

Result<MapArea> parse_area(const std::string& text) {
  COLLINEA_TRY(MapArea area, parse_map_points(text));
  if (area.size() > 1 && area.front() == area.back()) area.pop_back();
  if (area.size() < 3) return fail(Errc::kBadFormat, "an area needs three corners: easting, northing in each line");
  return area;
}

}  // namespace collinea
