// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>

#include "collinea/orient/internal/reconstruction.h"

namespace collinea {

/// True when global orientation is the better way to begin: many images, nearly all with positions.
[[nodiscard]] bool worth_global(const Block& setup);

/// Positions the largest part of the block that hangs together by pairs all at once, in the world of the image
/// positions: rotations averaged over the pairs, turned onto the bases between positions; centres from positions and
/// directions; points intersected with a wide tolerance that narrows from adjustment to adjustment, positions as
/// observations. Images that too few points hold are left out: growth brings them in. False, and nothing placed, when
/// the positions do not fix the block (too few, on one line, or contradicting the pairs). Error: stopped.
[[nodiscard]] Result<bool> orient_globally(Reconstruction& reconstruction, const Block& setup,
                                           std::span<const ImagePair> pairs, const OrientOptions& options,
                                           const Run& run);

}  // namespace collinea
