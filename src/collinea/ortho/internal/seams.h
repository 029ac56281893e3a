// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

#include "collinea/ortho/internal/view_costs.h"

namespace collinea {

/// For each cell the view whose image it takes: an index, or kNoView.
using Labels = Raster<std::int16_t>;

/// How far a label may depend on what lies around it [cells].
constexpr int kSeamReach = 2 * OrthoPatch::kBlock;

/// The views that cells are to be taken from, as large as the patch (kNoView: none), or empty.
struct WantedViews {
  Labels first, next;  ///< next: where the first cannot be had
};

/// The wanted view of each cell that sees it, or from which only small things keep the cell; else the cheapest view
/// (cost_of, worked out at the corners of blocks and interpolated) that sees it, these cells then straightened: they
/// follow the majority around them where that view sees them too. kNoView where no view sees a cell, but for pinholes
/// of a few cells, which follow their surroundings.
[[nodiscard]] Labels choose_views(const OrthoPatch& patch, std::span<const View* const> views,
                                  const WantedViews& wanted, Visibility& visibility);

/// Cells with a height that no view sees, but of whose 5 x 5 cells at most ten are such, take the view that most of the
/// others have: a tooth of the edge of a roof leaves such holes of a few cells, and what they show there is no worse
/// than that edge. Two cells along the border of the patch stay. `views`: how many there are.
void close_pinholes(const FloatImage& heights_m, std::size_t views, Labels& labels);

/// The weight of one view in each cell of a rectangle: 1 well inside its own area, falling to 0 within feather_cells on
/// both sides of its seams, and towards areas that it does not see. A label's own cells keep a little, so that
/// something is left where no other view sees them. Sum over the views is not 1.
struct ViewWeights {
  int column = 0, row = 0;  ///< of the rectangle in the patch
  FloatImage weight;        ///< empty when the view has no cells
};
[[nodiscard]] ViewWeights weights_of(const Labels& labels, std::int16_t view, int feather_cells,
                                     Visibility& visibility);

}  // namespace collinea
