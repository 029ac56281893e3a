// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/adjust/internal/problem.h"

namespace collinea::bundle {

/// Fills datum, rank_defect and datum_sources.
void find_datum(Problem& problem, const State& start);

}  // namespace collinea::bundle
