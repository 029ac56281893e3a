// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "collinea/adjust/solved.h"
#include "collinea/base/finding.h"

namespace collinea {

/// Pairs of unknowns, one of them in Problem::auxiliaries, that hardly differ in what they do (correlation beyond 0.99:
/// the sigma of each is seven times what it were without the other). By the selected inverse. A time offset is compared
/// with all three axes of a shift, a drift or a lever arm at once, by its multiple correlation with them.
[[nodiscard]] std::vector<Finding> inseparable_unknowns(const Solved& solved, bundle::TileCholesky& inverse);

/// That the unknown in this row of the normal equations (Solved::Factored) is not determined.
[[nodiscard]] Finding undetermined_unknown(const Solved& solved, int row);

}  // namespace collinea
