// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "collinea/quality/internal/rejection.h"

namespace collinea {

/// What is left without image points of control that miss the intersection of the other rays of their point by a
/// hundred sigmas and more (check_control()). These would bend the images they are in so much that the first
/// adjustment says nothing of anything else. At most `most`, in the order of Block::control_observations; their tests
/// and sizes follow from an adjustment (with_gross_errors()). `seed`: of the robust search for what is wrong.
[[nodiscard]] Remaining without_gross_control(Measurements measurements, int most, std::uint64_t seed);

}  // namespace collinea
