// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/quality/gross_errors.h"

namespace collinea {

/// Refuses an adjustment that is none; what is one passes. kIllPosed: the observations that are left, without image
/// points whose image does not see their point, are fewer than the unknowns or do not determine the block.
/// kNotConverged: it has not come to rest, or it has lost image points that have no gross error, which says where gross
/// errors have driven it and not what was measured. The message names what does not fit, the largest first, as far as a
/// robust fit can tell, else the largest residuals. An adjustment that failed keeps its error, with the same.
///
/// `block`, `scope`: that was adjusted. Costs nothing where is_bent() is false.
[[nodiscard]] Result<> refuse_diverged(const Result<Examined>& adjusted, const Block& block, const AdjustScope& scope,
                                       const ExamineOptions& options, const Run& run);

/// Adjusts and examines what is to be signed: to its end (examine_to_the_end()), and refuses what is no adjustment.
[[nodiscard]] Result<Examined> examine_strictly(const Block& block, const AdjustScope& scope,
                                                const ExamineOptions& options, const Run& run);

}  // namespace collinea
