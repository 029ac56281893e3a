// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/block/block.h"
#include "collinea/geometry/similarity3.h"

namespace collinea {

/// Moves poses and points of the block by the similarity; priors and control stay where they are.
void transform(Block& block, const Similarity3& world_from_block);

}  // namespace collinea
