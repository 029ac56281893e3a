// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/marking_project.h"

#include "collinea/block/world_frame.h"

namespace collinea {

double sigma_scale(const std::optional<AdjustmentRecord>& adjustment) {
  return adjustment ? adjustment->sigma_scale() : 1;
}

Result<MarkingProject> MarkingProject::read(const Project& project) {
  MarkingProject all;
  COLLINEA_TRY(all.block, project.store.read_block());
  if (count_oriented(all.block) == 0)
    return fail(Errc::kIllPosed, "the images are not oriented yet: bring the project to the step orient first");
  COLLINEA_TRY(all.covariances, project.store.read_covariances());
  all.observations = observations_by_image(all.block);
  COLLINEA_TRY(all.frame, world_frame(all.block));
  const auto adjustment = project.store.read_outcome<AdjustmentRecord>();
  if (!adjustment && adjustment.error().code != Errc::kNotFound) return tl::unexpected(adjustment.error());
  if (adjustment) all.sigma_scale = collinea::sigma_scale(*adjustment);
  return all;
}

}  // namespace collinea
