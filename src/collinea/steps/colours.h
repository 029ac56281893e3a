// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/project/project.h"

namespace collinea {

/// Gives every tie point the colour of its first image there. A photograph that cannot be read colours nothing.
[[nodiscard]] Result<> colour_tie_points(const Project& project, Block& block);

}  // namespace collinea
