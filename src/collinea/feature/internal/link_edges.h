// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "collinea/feature/edge_map.h"

namespace collinea {

/// An edge point and the pixel it was found in.
struct PixelEdge {
  int x = 0, y = 0;
  EdgePoint point;
};

/// Keeps points that hang together with one of an amplitude of `high`, follows them along their edge into chains of
/// `shortest` points or more, and puts points and chains into `map`. Points are in the order of pixels, one a pixel.
void link_edges(const std::vector<PixelEdge>& found, int width, int height, double high, std::size_t shortest,
                EdgeMap& map);

}  // namespace collinea
