// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "collinea/block/block.h"
#include "collinea/quality/internal/control_diagnosis.h"

namespace collinea {

/// Looks for blunders in the control of an oriented block in any frame, before it is adjusted: image measurements by
/// intersecting each point without one of its rays (a difference of more than six sigmas, three pixels and four times
/// the rest); exchanged axes by robust similarities to the points either way round (on flat ground by which of the two
/// leaves the images upright); coordinates by leaving out that point of four and more without which the others fit a
/// similarity best, or by the camera positions when there are fewer; constant offsets of camera positions by the median
/// difference after a robust similarity. Check points take part in the first two, since measurements are checked point
/// by point and a file has one order of columns; they decide nothing else, and one far off the control is named.
[[nodiscard]] ControlDiagnosis check_control(const Block& block, std::uint64_t seed = 1);

/// Does what the diagnosis recommends: removes excluded measurements (all those of an excluded point), shifts the
/// heights of positions, removes positions that are unusable. Exchanged axes are left to the reader of the control.
void apply(const ControlDiagnosis& diagnosis, Block& block);

}  // namespace collinea
