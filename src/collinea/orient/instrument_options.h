// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/adjust/bundle.h"
#include "collinea/block/instrument_options.h"
#include "collinea/quality/control_check.h"

namespace collinea {

/// A lever arm is given, or to be found.
[[nodiscard]] bool has_lever_arm(const InstrumentOptions& asked);
/// Something of the positions is to be found or taken into account.
[[nodiscard]] bool is_of_positions(const InstrumentOptions& asked);

/// Whether the words are among those there are, and the block has what they are about: positions, times, attitudes,
/// cameras of that name.
[[nodiscard]] Result<> check_instruments(const InstrumentOptions& asked);
[[nodiscard]] Result<> check_instruments(const InstrumentOptions& asked, const Block& block);

/// Puts it into the scope of an adjustment of an oriented block: strips and velocities come from its centres. Errors as
/// check_instruments().
[[nodiscard]] Result<> add_instruments(const Block& block, const InstrumentOptions& asked, AdjustScope& scope);

/// Where their shift is to be found, positions that lie off the control by a constant are what was expected, unless by
/// so much that they belong to another coordinate system.
void expect_shift(ControlDiagnosis& diagnosis);

}  // namespace collinea
