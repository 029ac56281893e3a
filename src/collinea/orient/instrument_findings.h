// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "collinea/quality/examine.h"

namespace collinea {

/// What was found of lever arms, shifts, drifts, time offsets and boresights, a line each, and what of it can hardly be
/// separated.
[[nodiscard]] std::vector<std::string> instrument_findings(const Block& block, const Examined& adjusted);

}  // namespace collinea
