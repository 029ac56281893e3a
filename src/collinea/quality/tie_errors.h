// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
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

  /// That of a point with so many rays, as an index in `classes`; nothing when there are none.
  [[nodiscard]] std::optional<std::size_t> class_of(int rays) const;
  /// The same.
  [[nodiscard]] const ErrorDistribution* of(int rays) const;
};

/// Fits the errors by classes of 2, 3, 4 to 5, 6 to 9 and 10 rays and more; those with fewer than 500 errors join
/// their neighbour.
[[nodiscard]] TieErrors fit_tie_errors(const std::vector<RayError>& errors);

/// How an adjustment takes tie points whose errors are like that: their sigmas times a factor, and a loss.
struct TieLoss {
  double sigma_factor = 1;
  Loss::Kind loss = Loss::kNone;
  double loss_scale_sigmas = 2;
};

/// The loss by which the adjusted values are those of greatest likelihood: none for normal errors; of Student's with nu
/// degrees of freedom Cauchy's with k^2 = nu + 2, for sigmas that are nu / (nu + 2) of the squared scale (Lange,
/// Little, Taylor 1989). Scale and 1 / nu are means over the classes of three rays and more, in proportion of their
/// errors; those of two rays show the sum of two errors. Nothing when there are no classes.
///
///     const auto shown = loss_of(clean.found.errors);
///     SigmaFactors factors = as_given();
///     factors[std::size_t(ObservationGroup::kTieImages)] = shown->sigma_factor;
///     options.adjust.loss = shown->loss;
///     options.adjust.loss_scale_sigmas = shown->loss_scale_sigmas;
///     examine(with_sigmas(clean.block, factors), scope, options, run);
///
/// Covariances are those of the estimate under that loss (RobustSquares::information()); sigma0 is not 1 but, of three
/// degrees of freedom, 1.3: it is that of normal residuals with the same weighted squares. On photographs least squares
/// comes nearer to the truth than it, although their errors have long tails: neighbouring errors are alike.
[[nodiscard]] std::optional<TieLoss> loss_of(const TieErrors& errors);

}  // namespace collinea
