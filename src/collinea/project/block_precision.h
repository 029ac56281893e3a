// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "collinea/quality/joint_poses.h"
#include "collinea/store/project_store.h"

namespace collinea {

/// Larger blocks have no factor of their normal equations while somebody waits.
inline constexpr std::size_t kMostImagesAtOnce = 3000;

/// What the adjustment of a project knows of its images together. The equations are set up anew where the adjustment
/// ended (`adjusted`, as the store has it), with what took part in it by the setup and the record of the step. Errors:
/// kUnsupported, the block is larger than kMostImagesAtOnce, or its images do not come out as precise, within 10 % of
/// their variances, as `known` has them (what snooping rejected is not recorded in all its details, and the setup may
/// have been edited since); those of adjustment_of() and BlockPrecision.
[[nodiscard]] Result<BlockPrecision> precision_of(const std::filesystem::path& project, const Block& adjusted,
                                                  const BlockCovariances& known);

}  // namespace collinea
