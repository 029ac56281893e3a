// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "collinea/base/finding.h"
#include "collinea/block/block.h"

namespace collinea {

/// Positions that a robust loss cannot hold back.
struct OutweighingPositions {
  std::vector<ImageId> images;
  std::vector<Finding> findings;
};

/// Images whose positions contradict those of the others (robust_similarity() of block and world) and would move the
/// block all the same: a gross error pulls with 2 / sigma under Huber's loss, however large it is, so that one with two
/// centimetres outweighs hundreds with five metres. Named when their pulls together exceed half of those that agree. At
/// most two are: three that agree may be the good ones. None where fewer than four others agree.
[[nodiscard]] OutweighingPositions outweighing_positions(const Block& block, std::uint64_t seed);

}  // namespace collinea
