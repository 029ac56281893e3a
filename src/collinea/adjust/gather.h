// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/adjust/adjust_options.h"
#include "collinea/adjust/adjust_scope.h"
#include "collinea/adjust/internal/problem.h"
#include "collinea/base/result.h"
#include "collinea/block/block.h"

namespace collinea::bundle {

/// Gathers what takes part. Errors as adjust() says.
[[nodiscard]] Result<ProblemAndStart> gather(const Block& block, const AdjustScope& scope,
                                             const AdjustOptions& options);

}  // namespace collinea::bundle
