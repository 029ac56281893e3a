// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/marking_project.h"

#include "collinea/block/world_frame.h"
#include "collinea/project/block_precision.h"

namespace collinea {

double sigma_scale(const std::optional<AdjustmentRecord>& adjustment) {
  return adjustment ? adjustment->sigma_scale() : 1;
}

MarkingBlock MarkingProject::marking() const {
  MarkingBlock marking{block, observations, covariances.poses, sigma_scale};
  if (precision)
    marking.poses_together = [its = precision](std::span<const ImageId> images) { return its->joint_poses(images); };
  return marking;
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

Result<MarkingProject> MarkingProject::read_with_precision(const Project& project) {
  COLLINEA_TRY(MarkingProject all, read(project));
  if (auto precision = precision_of(project.folder, all.block, all.covariances))
    all.precision = std::make_shared<BlockPrecision>(*std::move(precision));
  return all;
}

}  // namespace collinea
