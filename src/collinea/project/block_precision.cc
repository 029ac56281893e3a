// SPDX-License-Identifier: Apache-2.0
#include "collinea/project/block_precision.h"

#include <algorithm>
#include <cmath>

#include "collinea/project/adjustment_task.h"

namespace collinea {
namespace {

bool is_as_precise(BlockPrecision& precision, const BlockCovariances& known) {
  constexpr std::size_t kMostCompared = 20;
  constexpr double kAlike = 0.1;  // of a variance
  const std::size_t step = std::max<std::size_t>(1, known.poses.size() / kMostCompared);
  std::size_t number = 0;
  for (const auto& [image, covariance] : known.poses) {
    if (number++ % step != 0) continue;
    const auto joint = precision.joint_poses({&image, 1});
    if (!joint) return false;
    for (int k = 0; k < 6; ++k)
      if (!(std::abs(joint->covariance(k, k) - covariance(k, k)) <= kAlike * covariance(k, k))) return false;
  }
  return !known.poses.empty();
}

}  // namespace

Result<BlockPrecision> precision_of(const std::filesystem::path& folder, const Block& adjusted,
                                    const BlockCovariances& known) {
  if (count_oriented(adjusted) > kMostImagesAtOnce)
    return fail(Errc::kUnsupported, "the block has more than " + std::to_string(kMostImagesAtOnce) + " images");
  COLLINEA_TRY(const Project project, open_project(folder, {}));
  COLLINEA_TRY(const ProjectAdjustment ended, adjustment_in_force(project, adjusted));
  const AdjustmentTask& task = ended.task;
  COLLINEA_TRY(BlockPrecision precision, BlockPrecision::of(task.block, task.scope, task.options.adjust, {}));
  if (!is_as_precise(precision, known))
    return fail(Errc::kUnsupported, "the equations of the adjustment cannot be set up again as they were");
  return precision;
}

}  // namespace collinea
