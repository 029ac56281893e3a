// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "collinea/adjust/adjust_options.h"
#include "collinea/block/block.h"
#include "collinea/quality/internal/error_mixture.h"

namespace collinea {

/// The error of a ray of a tie point, and how many rays its point has.
struct RayError {
  CheckedError error;
  int rays = 0;
};

/// What the errors of tie points are distributed like, apart for points with few and with many rays: the errors of the
/// other rays of its point are part of what a residual shows, which makes those of few rays more alike to normal ones;
/// and wrong matches agree with one other ray more often than with three.
struct TieErrors {
  struct Class {
    int least_rays = 2;  ///< of a point; up to those of the next class
    long errors = 0;
    ErrorDistribution distribution;
  };
  std::vector<Class> classes;  ///< ascending; empty when there are too few errors

  /// That of a point with so many rays; nothing when `classes` is empty.
  [[nodiscard]] const ErrorDistribution* of(int rays) const;
};

/// Fits the errors by classes of 2, 3, 4 to 5, 6 to 9 and 10 rays and more; those with fewer than 500 errors join
/// their neighbour.
[[nodiscard]] TieErrors fit_tie_errors(const std::vector<RayError>& errors);

}  // namespace collinea
