// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "collinea/raster/geotiff.h"
#include "collinea/vector/vector_areas.h"

namespace collinea {

/// A part of the map that is to be taken from one view.
struct SeamPolygon {
  std::uint16_t source = 0;    ///< 1 + index of the view
  std::vector<MapRing> rings;  ///< the outline, then its holes

  friend bool operator==(const SeamPolygon&, const SeamPolygon&) = default;
  template <class Visit>
  static void fields(Visit&& visit) {
    visit("source", &SeamPolygon::source);
    visit("rings", &SeamPolygon::rings);
  }
};

/// Gives the areas of equal source (0: none, stays) that hang together by sides and have fewer cells to the neighbour
/// with the longest common border; an area among nothing stays.
void absorb_small_areas(std::size_t fewest_cells, Raster<std::uint16_t>& source);

/// The areas of equal source (0: none, left out) that hang together by sides of cells, as polygons along the sides:
/// every side is given twice by the same two corners, so that neighbours fit without gap or overlap; outlines clockwise
/// on the map, holes the other way; no ring meets itself, rings of one polygon meet in single corners at most. In the
/// order of their first cells.
[[nodiscard]] std::vector<SeamPolygon> outlines_of(const Raster<std::uint16_t>& source, const MapGrid& grid);

/// Sets the cells of a part of a grid (from column, row on) whose centres lie in the polygons; where polygons overlap,
/// the later one lies on top, and `below` gets what lies under it.
void fill(const std::vector<SeamPolygon>& polygons, const MapGrid& grid, int column, int row,
          Raster<std::uint16_t>& source, Raster<std::uint16_t>& below);

}  // namespace collinea
