// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "collinea/adjust/adjust_options.h"
#include "collinea/adjust/adjust_scope.h"
#include "collinea/adjust/internal/problem.h"
#include "collinea/base/result.h"
#include "collinea/base/run.h"
#include "collinea/block/block.h"
#include "collinea/math/tile_cholesky.h"

namespace collinea::bundle {

/// The normal equations N of poses and cameras (points eliminated) of a block where it stands, without a step: whoever
/// knows a better position than these observations alone would lead to linearises there.
struct ReducedSystem {
  std::unique_ptr<const Problem> problem;
  State state;               ///< the block as it stands
  TileCholesky factor;       ///< of N, in the datum of Solved::factor()
  std::vector<double> step;  ///< by which the observations would move poses and cameras from there, N^-1 g
};

/// Errors: those of adjust(); kIllPosed when something is not determined.
[[nodiscard]] Result<ReducedSystem> reduced_system(const Block& block, const AdjustScope& scope,
                                                   const AdjustOptions& options, const Run& run);

}  // namespace collinea::bundle
