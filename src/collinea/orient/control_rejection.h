// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <set>
#include <vector>

#include "collinea/base/finding.h"
#include "collinea/block/block.h"

namespace collinea {

/// What is known of a block, without the control and the positions that were found wrong.
struct CheckedSetup {
  Block setup;
  std::set<ControlId> excluded;  ///< control points that were rejected
  std::vector<Finding> findings;
};

/// Examines control against positions and control points against each other, see check_control(), and does what the
/// diagnosis recommends. Before that, marks that fit another system of image coordinates are brought into the images
/// where that is certain, see check_marks(), and those that lie outside their images are removed. Exchanged columns of
/// the control are put right; where that leads more than 100 km away from the block, no control is used. `block`:
/// oriented, in any frame, with the control of `setup`. With `expects_shift` a constant offset of the positions is no
/// error, see expect_shift().
[[nodiscard]] CheckedSetup reject_wrong_control(Block block, Block setup, bool expects_shift, std::uint64_t seed);

}  // namespace collinea
