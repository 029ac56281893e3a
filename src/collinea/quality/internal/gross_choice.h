// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "collinea/quality/examine.h"
#include "collinea/quality/internal/misfit.h"
#include "collinea/quality/internal/rejection.h"

namespace collinea {

/// What is grossly wrong in a block, as far as it can be told.
struct GrossChoice {
  Remaining remaining;            ///< without what is wrong for certain (Rejected::round 0), at the poses of the fit
  std::vector<Misfit> undecided;  ///< gross, but others may be wrong instead, or the block needs it
  std::vector<KeptSuspect> kept;  ///< these and those others
  bool contradiction = false;     ///< half of the coordinates are gross: nothing tells which, and nothing goes
};

/// Finds what is grossly wrong by a robust fit (robust_fit()) and decides what of it goes.
///
/// A linear test of a gross error that bends the block says nothing. So its value is first replaced by what the robust
/// fit says of it: in that block, which nothing bends, its redundancy number r, the standard deviation of its misfit
/// and the correlations rho of its test with those of others are what they are for any size of the error; w is the
/// misfit over that standard deviation. The rho are those of Rivals: without it the redundancy number of another is r
/// (1 - rho^2). It goes unless another measurement on the ground may be wrong in its place:
///
///  - rho > 0.99, and an adjustment without the other in its place fits as well (so a large error shows where a small
///    one does not: heights of four points that are tilted by it shorten their distances in plan);
///  - r < 0.1, and w (1 - rho) < limit sqrt(2 (1 - rho)), by which the difference of two tests is significant.
///
/// Image points need no such doubt: those of a tie point with two rays go both. Fixed coordinates and image points that
/// their image does not see go without a test. Attitudes are left to the rounds of data snooping.
///
/// Nothing where nothing is gross, or where there is no fit. Cost: that of the
/// fit, two adjustments with their tests and one for each of those on the ground and each rival.
[[nodiscard]] std::optional<GrossChoice> choose_gross(const Measurements& given, const ExamineOptions& options,
                                                      int most, const Run& run);

/// The misfit as a measurement that is rejected: its size is its misfit, its sigma that given.
[[nodiscard]] Rejection gross_rejection(const Misfit& misfit, const Measurements& given);

}  // namespace collinea
