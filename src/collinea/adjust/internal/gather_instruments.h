// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/adjust/adjust_scope.h"
#include "collinea/adjust/internal/problem.h"
#include "collinea/base/result.h"
#include "collinea/block/block.h"

namespace collinea::bundle {

/// Fills Problem::positions, attitudes and verticals of the free images, with the unknowns of their instruments. Errors
/// as adjust().
[[nodiscard]] Result<> lay_out_instruments(const Block& block, const AdjustScope& scope, ProblemAndStart& out);

}  // namespace collinea::bundle
