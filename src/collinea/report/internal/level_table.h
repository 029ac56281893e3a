// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>

#include "collinea/dense/level_matching.h"

namespace collinea {

/// What each level of a surface did: a title and a line a level.
[[nodiscard]] std::string level_table(std::span<const LevelCount> levels);

}  // namespace collinea
