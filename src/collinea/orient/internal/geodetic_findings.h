// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <set>
#include <vector>

#include "collinea/adjust/bundle.h"

namespace collinea {

/// What was measured on the ground (Block::geodetic of `setup`) and differs from the adjusted block by more than chance
/// explains, worst first. What is `excluded` was doubted before.
[[nodiscard]] std::vector<Finding> geodetic_findings(const Block& setup, const Adjusted& adjusted,
                                                     const std::set<std::size_t>& excluded);

}  // namespace collinea
