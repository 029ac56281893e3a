// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/surface/height_field.h"

namespace collinea {

/// Edges of a surface lie where matching put them: within some cells of the true ones (foreground fattening, gaps that
/// were filled). The surface with all edges moved by that far: outwards every cell near a wall has the height of the
/// highest one in reach, inwards that of the lowest. A wall is where neighbouring cells differ by more than 60 degrees;
/// all else stays as it is. `field` must outlive it.
[[nodiscard]] HeightField moved_edges(const HeightField& field, bool outwards);
/// Cells, along each axis: half a matching window of 9, and what resampling adds.
inline constexpr int kEdgeReach = 5;
inline constexpr double kWallSlope = 1.73205;  ///< tan 60 degrees

}  // namespace collinea
