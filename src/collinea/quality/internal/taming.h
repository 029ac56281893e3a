// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "collinea/quality/examine.h"
#include "collinea/quality/internal/misfit.h"
#include "collinea/quality/internal/rejection.h"

namespace collinea {

/// A gross error of which a part is left.
struct TamedMisfit : Misfit {
  double left = 1;  ///< that part of it
};

/// Measurements whose gross errors were made so small that linear equations describe what they do.
struct Tamed {
  Remaining remaining;             ///< without what no test can reject
  std::vector<TamedMisfit> tamed;  ///< still there, with a smaller error; the largest first
};

/// Finds what is grossly wrong by a robust fit (robust_fit()) and makes it as small as it can be and still be found for
/// certain: of its misfit is left four times what is found with the stated power where everything is right, thirty
/// sigmas at least. So whether it is that measurement that is wrong, or another, or whether that cannot be told, is
/// decided by tests in a block that nothing bends. Poses and points are those of the fit.
///
/// Image points that their image does not see and fixed coordinates, which no test can reject, go at once
/// (Rejected::round 0). Attitudes stay as they are. Nothing where nothing is gross, or where there is no fit.
[[nodiscard]] std::optional<Tamed> tame(const Measurements& given, const ExamineOptions& options, const Run& run);

/// Gives the tamed their values again, in the measurements where they are left and in the rejections, whose tests grow
/// with them.
[[nodiscard]] Remaining as_given(Remaining remaining, const std::vector<TamedMisfit>& tamed, const Measurements& given);

/// The misfit as a measurement that may have to be rejected: its size is its misfit, its sigma that given.
[[nodiscard]] Rejection gross_rejection(const Misfit& misfit, const Measurements& given);

}  // namespace collinea
