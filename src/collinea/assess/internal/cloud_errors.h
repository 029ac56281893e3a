// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

#include "collinea/assess/internal/levelled.h"
#include "collinea/base/run.h"
#include "collinea/surface/height_field.h"

namespace collinea {

/// How well the standard deviations of a cloud's points tell their errors.
struct CloudErrors {
  std::size_t points = 0;    ///< looked at
  double within_bounds = 0;  ///< share whose error is below kBoundSigmas
  double share_gross = 0;    ///< above kGrossSigmas
  struct ByImages {
    int images = 0;
    std::size_t points = 0;  ///< of those not gross
    double rms = 0;          ///< of their errors in sigmas: 1 where these are right
  };
  std::vector<ByImages> by_images;
};

/// Heights of the points of a LAS file against the true surface, less the plane of all errors (take_off_plane), where
/// the true slope is below 0.3 and no step lies within 6 cells of the truth. Of large clouds every so many points are
/// looked at. Points without a standard deviation do not count. No points: there are too few for that plane, or all on
/// a line. Errors: reading; cancelled.
[[nodiscard]] Result<CloudErrors> cloud_errors(const std::filesystem::path& cloud, const HeightField& truth,
                                               const Run& run);

}  // namespace collinea
