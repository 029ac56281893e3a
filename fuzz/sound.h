// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/block/block.h"

namespace collinea::fuzz {

/// What every reader of blocks owes to those who compute with them: numbers are finite, rotations are rotations,
/// standard deviations positive, and what is named is there. Throws where that does not hold: a defect of the reader.
void check_sound(const Block& block);

}  // namespace collinea::fuzz
