// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "collinea/block/block.h"
#include "collinea/geometry/robust_similarity.h"
#include "collinea/geometry/similarity3.h"

namespace collinea {

/// The similarity that brings a block into the frame of its control points or camera positions, and what agreed on it.
struct Datum {
  Similarity3 world_from_block;
  std::vector<ImageId> images;     ///< whose positions agree
  std::vector<ControlId> control;  ///< that agree
  bool by_control = false;         ///< control points alone; otherwise positions (with control, where there is some)
};

/// Projection centres beside the positions that receivers measured, where these have all three coordinates with a
/// standard deviation (root mean square of the axes); appends the images to `images`.
[[nodiscard]] std::vector<bundle::PositionPair> position_pairs(const Block& block, std::vector<ImageId>& images);

/// Estimates the datum robustly (least median of squares over triples, then iterated least squares of those within
/// 27^1/2 robust standard deviations of one coordinate). Control points in three and more positions decide alone,
/// because receivers' positions may be systematically off; with fewer, camera positions decide, together with the
/// control there is. Control points are intersected from their image measurements, whatever frame the block is in.
/// Nothing when fewer than three positions are known or when they lie on one line (within a thousandth of its length,
/// or within their own uncertainty).
[[nodiscard]] std::optional<Datum> datum(const Block& block, bool use_positions = true, bool use_control = true,
                                         std::uint64_t seed = 1);

}  // namespace collinea
