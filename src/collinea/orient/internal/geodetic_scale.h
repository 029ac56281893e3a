// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "collinea/base/finding.h"
#include "collinea/block/block.h"

namespace collinea {

/// The scale of a block by the distances measured between its control points.
struct GeodeticScale {
  double scale = 1;                   ///< metres to a unit of the block
  double sigma = 0;                   ///< relative, by the sigmas of distances and image measurements
  int distances = 0;                  ///< that agree on it
  std::vector<std::size_t> excluded;  ///< indices in Block::geodetic of distances that contradict the others
  std::vector<Finding> findings;
};

/// The weighted mean of given over intersected length of the distances that agree with the one that most agree with:
/// within five standard deviations of the two or a thousandth, whichever is more. With two that do not agree nothing
/// tells which is wrong: both are kept, and that is reported. Nothing when no distance has both points intersected from
/// two images.
[[nodiscard]] std::optional<GeodeticScale> geodetic_scale(const Block& block);

}  // namespace collinea
