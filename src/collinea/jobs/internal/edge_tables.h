// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "collinea/feature/curves.h"
#include "collinea/feature/ellipse.h"
#include "collinea/feature/hough.h"
#include "collinea/feature/line_corners.h"
#include "collinea/feature/target.h"
#include "collinea/io/text_table.h"

// Tables of edges and of what was found among them; a row each, columns with units.
namespace collinea {

[[nodiscard]] TextTable table_of(const std::vector<FoundLine>& lines);
/// Lines by their numbers in the table of lines.
[[nodiscard]] TextTable table_of(const std::vector<LineCorner>& corners);
[[nodiscard]] TextTable table_of(const std::vector<FoundCircle>& circles);
[[nodiscard]] TextTable table_of(const std::vector<EdgeEllipse>& ellipses);
/// With names in place of numbers where there are any.
[[nodiscard]] TextTable table_of(const std::vector<Target>& targets, const std::vector<std::string>& names);
[[nodiscard]] TextTable table_of(const std::vector<FoundShape>& shapes, const ShapeSearch& search);

/// Chains, with the vertices of their polygons counted.
[[nodiscard]] TextTable chain_table(const EdgeMap& map, double polygon_px);
/// Points of all chains with their psi-s representation.
[[nodiscard]] TextTable edge_point_table(const EdgeMap& map, double curvature_px);
/// Chain codes.
[[nodiscard]] TextTable code_table(const EdgeMap& map);
/// Magnitudes of Fourier descriptors against the first, of closed chains.
[[nodiscard]] TextTable descriptor_table(const EdgeMap& map);

[[nodiscard]] Curve curve_of(const EdgeMap& map, const EdgeChain& chain);

}  // namespace collinea
