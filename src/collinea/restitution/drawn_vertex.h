// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/restitution/plotted_vertex.h"

namespace collinea {

/// A plotted vertex as a drawing keeps it: with its covariance in the map and the marks that gave it.
[[nodiscard]] DrawnVertex drawn_vertex(VertexPlotter& plotter, const AskedVertex& asked, const PlottedVertex& plotted,
                                       const Block& block);

/// A vertex of a drawing with its marks in the images that the block has.
[[nodiscard]] RepeatedVertex repeated_vertex(const DrawnVertex& vertex, const Block& block);

}  // namespace collinea
