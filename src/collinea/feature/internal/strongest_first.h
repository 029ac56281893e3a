// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/block/features.h"

namespace collinea {

/// The same features in the order of their strength; of equal ones those that stand first.
[[nodiscard]] Features strongest_first(const Features& features);

}  // namespace collinea
