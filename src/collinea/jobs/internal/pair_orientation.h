// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "collinea/jobs/internal/pair_steps.h"

namespace collinea {

/// A pair whose relative orientation is the last one of the report.
struct OrientedPair {
  PairImages images;  ///< as the surface is found on them
  std::vector<MatchedPoint> points;
};

/// Points are looked for, and measured to fractions of a pixel, on images of moderate size; on larger ones they are
/// measured again, which moves them by less than a pixel of the smaller ones. With `given` they are only compared with
/// it. Fills `search` and `orientations` of the report. Errors: files, as find_pair_points() and
/// relative_orientation(); stopped.
[[nodiscard]] Result<OrientedPair> orient_pair(const PairFiles& pair, const PairShrinks& shrinks,
                                               const PairChainOptions& options, PairReport& report, const Run& run,
                                               const std::optional<GivenPair>& given = {});

/// With the epipolar pair of these images and a base of that length. Errors: as epipolar_pair().
[[nodiscard]] Result<ModelOfPair> model_of(const OrientedPair& pair, const RelativeOrientation& orientation,
                                           double base);

}  // namespace collinea
