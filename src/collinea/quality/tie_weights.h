// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/adjust/bundle.h"
#include "collinea/quality/tie_errors.h"

namespace collinea {

/// How the rays of tie points were weighted by their errors.
struct TieWeights {
  TieErrors errors;                      ///< the distribution, in standard deviations as they were before
  double scale = 1;                      ///< of Student's distribution, in those
  double degrees_of_freedom = 0;         ///< infinite: normal errors, nothing was changed
  double least = 1, lower_quartile = 1;  ///< weights, the mean being about 1
  int rounds = 0;                        ///< adjustments
  bool converged = true;
};

/// Standard deviations of the rays of tie points by their errors. Errors of tie points have Student's distribution:
/// that of a normal one whose variance differs from ray to ray as 1 / chi-squared. Where features lie on things that
/// look different from elsewhere (edges of roofs, trees) they are several times those on the ground between, and alike
/// in many points at once; alike weights let them bend the block. By expectation and maximisation (Lange, Little,
/// Taylor 1989): adjust; with the error T of each ray in d directions (CheckedError) the expectation of 1 / variance is
///
///     w = (nu + d) / (nu + T^2 / s^2),      sigma <- sigma s / sqrt(w),
///
/// s and nu those of points with three rays and more (loss_of()) in the first adjustment, whose weights are alike (from
/// weighted ones tails look longer and longer); adjust again, until weights change by less than 2 % as root mean
/// square, at most eight times. These are the estimates of greatest likelihood, as under Cauchy's loss with k^2 = nu +
/// 2; but as standard deviations of the rays, so that least squares, sigma0, redundancy, tests and covariances of all
/// else are those of any adjustment. Taking the weights as known makes standard deviations from tie points too small by
/// the root of (nu + d) / (nu + d + 2), a sixth of three degrees of freedom.
///
/// Sigmas of Block::observations become those; poses, cameras and points those of the last adjustment. Normal errors or
/// fewer than 500 rays that others check: nothing changes. Errors: those of adjust().
[[nodiscard]] Result<TieWeights> weigh_ties(Block& block, const AdjustScope& scope, const AdjustOptions& options,
                                            const Run& run);

}  // namespace collinea
