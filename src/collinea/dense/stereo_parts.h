// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "collinea/dense/stereo.h"

namespace collinea {

/// A rectangle of the left image of an epipolar pair, and the disparities it may have.
struct StereoPart {
  int column = 0, row = 0, width = 0, height = 0;
  DisparityRange range;
};

struct StereoParts {
  std::vector<StereoPart> parts;  ///< row by row, without those that the right image does not show
  double work = 0;                ///< pixels times disparities of all parts, with their margins
  double work_before = 0;         ///< of the pair at reduced size that told their ranges
};

/// A pair too large to be matched as a whole, in parts that each have a range of disparities of their own: what
/// match_pair() finds there on images reduced to some four million pixels (all but a thousandth on either side),
/// widened by two of their pixels and a sixth. Where that finds nothing, what it finds next to it. `range`: of the
/// whole pair. Memory: a quarter of the images more. Errors: as match_pair().
[[nodiscard]] Result<StereoParts> stereo_parts(const GreyImage& left, const GreyImage& right,
                                               const DisparityRange& range, const StereoOptions& options,
                                               const Run& run);

/// Disparities of the pixels of a part, as match_pair() finds them of it with a margin of 48 pixels. Memory: 100 MB and
/// 40 bytes a pixel, or more where a square of 256 pixels takes that. Errors: as match_pair().
[[nodiscard]] Result<DisparityMap> match_part(const GreyImage& left, const GreyImage& right, const StereoPart& part,
                                              const StereoOptions& options, const Run& run);

}  // namespace collinea
