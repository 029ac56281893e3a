// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/orient/orient.h"
#include "collinea/store/step_records.h"

namespace collinea {

/// What the project keeps of an orientation beside its block. `setup`: the block that was oriented, with all of its
/// measurements; control that was excluded is compared by these.
[[nodiscard]] OrientationRecord record_of(const Orientation& orientation, const Block& setup);

}  // namespace collinea
