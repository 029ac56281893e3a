// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/adjust/block_motion.h"

namespace collinea::bundle {

/// Shifts, turns and scales the block as a whole so that positions, verticals, control coordinates and what was
/// measured on the ground fit best (what each kind of observation adds in add_to_gauge()); image residuals stay as they
/// are. Orientations of set-ups and common heights go with it. A linear step does that badly: precise rays resist a
/// turn by its second-order error, so that a block that lies askew creeps home. Answers by how much the cost fell; 0
/// and nothing done where it does not, and unless problem.moves_as_one.
double settle_gauge(const Problem& problem, State& state);

}  // namespace collinea::bundle
