// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "collinea/quality/examine.h"

namespace collinea {

/// What was found of lever arms, shifts, drifts, time offsets and boresights, and what of it can hardly be
/// separated.
[[nodiscard]] std::vector<Finding> instrument_findings(const Examined& adjusted);

}  // namespace collinea
