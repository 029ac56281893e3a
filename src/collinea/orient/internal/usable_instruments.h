// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "collinea/adjust/bundle.h"
#include "collinea/base/finding.h"
#include "collinea/block/instrument_options.h"

namespace collinea {

/// Lever arms, shifts, drifts, time offsets and attitudes that a placed block can have.
struct UsableInstruments {
  InstrumentOptions options;      ///< those asked for, without what cannot take part
  std::vector<Finding> findings;  ///< what was asked for in vain: kPositionsUnused, kAttitudesUnused, kShiftUnused
};

/// What is of positions needs positions that take part, in the world; attitudes need the world; a shift of positions
/// needs a surveyed control point that two images see. `scope`: of the placed block.
[[nodiscard]] UsableInstruments usable_instruments(const InstrumentOptions& asked, const Block& setup,
                                                   const AdjustScope& scope, bool georeferenced);

}  // namespace collinea
