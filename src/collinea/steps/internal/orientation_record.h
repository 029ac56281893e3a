// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/orient/orient.h"
#include "collinea/store/step_records.h"

namespace collinea {

/// What the project keeps of an orientation beside its block.
[[nodiscard]] OrientationRecord record_of(const Orientation& orientation);

}  // namespace collinea
