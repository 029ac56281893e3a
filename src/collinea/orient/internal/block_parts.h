// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "collinea/orient/internal/reconstruction.h"

namespace collinea {

/// What hangs together by pairs: the part that is the block, and what does not hang together with it.
struct BlockParts {
  Reconstruction largest;
  bool in_world = false;                     ///< the positions of its images placed it, and it keeps them
  std::vector<std::vector<ImageId>> others;  ///< images of each other part, from three images on
};

/// Orients the parts of a block, each in a gauge of its own, until no two images are left that fit together: from all
/// positions at once or from an initial pair (options.mode), then image after image. Growth takes the tracks that it
/// needs; the largest part is then extended by all the others. Errors: no two images fit together; mode global where
/// positions do not fix the block; keypoints not readable; cancelled.
[[nodiscard]] Result<BlockParts> grow_parts(const Block& setup, std::span<const ImagePair> pairs,
                                            const KeypointSource& keypoints, const OrientOptions& options,
                                            const Run& run);

}  // namespace collinea
