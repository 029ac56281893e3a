// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "collinea/base/finding.h"
#include "collinea/block/block.h"

namespace collinea {

/// Points that are seen in fewer than two images and not measured on the ground either: a finding each.
[[nodiscard]] std::vector<Finding> unseen_control(const Block& setup);

/// Findings with these as they are of the block now.
[[nodiscard]] std::vector<Finding> with_unseen_control(std::vector<Finding> findings, const Block& setup);

}  // namespace collinea
