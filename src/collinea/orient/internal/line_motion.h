// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "collinea/block/block.h"

namespace collinea {

/// What residuals show of a turn of the camera while an image was read out line by line (rolling shutter).
struct ImageMotion {
  ImageId image;
  double explained = 0;  ///< share of its residual variance
};

struct LineMotion {
  double explained = 0;             ///< share of the residual variance of all these images; noise alone: 0
  std::vector<ImageMotion> images;  ///< the most explained first
};

/// For every image with enough tie points of three rays and more: its robust residuals by six unknowns of the pose and,
/// beside them, three of a turn that grows from line to line. Points and cameras are fixed, the fall in variance pays
/// for the three unknowns. Lines run along rows or columns of the images (a telephone held upright), whichever
/// explains more.
[[nodiscard]] LineMotion line_motion(const Block& oriented);

}  // namespace collinea
