// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "collinea/base/result.h"

namespace collinea {

/// A simple polygon on the map, east and north [m], closed from the last to the first corner.
using MapArea = std::vector<Eigen::Vector2d>;

[[nodiscard]] double size_m2(const MapArea& area);

/// Reads positions: easting and northing a line, between commas or blanks; # starts a comment, a line without numbers
/// above all others is a title, further fields are left alone. Errors name the line.
[[nodiscard]] Result<std::vector<Eigen::Vector2d>> parse_map_points(const std::string& text);
/// The same as the corners of an area; the first may stand at the end once more. Also an error: fewer than three.
[[nodiscard]] Result<MapArea> parse_area(const std::string& text);

}  // namespace collinea
