// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "collinea/base/finding.h"
#include "collinea/block/block.h"

namespace collinea {

/// Whether the image measurements of a block that came from a file were counted otherwise than in pixels to the right
/// and downwards from the upper-left corner: kMarksCountedOtherwise, kMarksMirrored, or nothing. To be asked before
/// approximate(), with the poses and coordinates that the file states.
///   - Where it states poses: by the rays of tie points and control, see check_marks().
///   - Else by control: each image with four marks of it and more is resected as given, with rows upwards, columns and
///     rows exchanged, or counted from its middle. A system is named when its residuals are three times smaller in
///     total. Above flat ground mirrored images fit as well, with the cameras beneath the ground: then a system is
///     named (as weak, since points may lie on a ceiling) that fits no worse and brings the cameras above their points.
/// Nothing is changed: a mirrored lens would have to be mirrored with its measurements.
[[nodiscard]] std::vector<Finding> mirrored_measurements(const Block& block, std::uint64_t seed);

}  // namespace collinea
