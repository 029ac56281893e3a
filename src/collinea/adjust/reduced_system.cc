// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/reduced_system.h"

#include <utility>

#include "collinea/adjust/gather.h"
#include "collinea/adjust/internal/normals.h"

namespace collinea::bundle {
Result<ReducedSystem> reduced_system(const Block& block, const AdjustScope& scope, const AdjustOptions& options,
                                     const Run& run) {
  COLLINEA_TRY(ProblemAndStart gathered, gather(block, scope, options));
  auto problem = std::make_unique<const Problem>(std::move(gathered.problem));
  KeptFactor kept;
  kept.meet(*problem);
  Normals normals(*problem, kept);
  Step step;
  normals.accumulate(gathered.start, 0, run, kExactDatum);
  const bool is_solved = normals.solve(run, step);
  int failed_row = -1;
  auto factor = normals.factor(run, kLeastPivot, failed_row);
  if (run.stopped()) return fail(Errc::kCancelled, "bundle adjustment stopped");
  if (!factor || !is_solved)
    return fail(Errc::kIllPosed, "images of the block are not determined: adjust it to see which");
  return ReducedSystem{std::move(problem), std::move(gathered.start), *std::move(factor), std::move(step.reduced)};
}

}  // namespace collinea::bundle
