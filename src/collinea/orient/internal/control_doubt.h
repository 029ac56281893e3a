// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <utility>

#include "collinea/adjust/bundle.h"
#include "collinea/quality/variance_components.h"

namespace collinea {

/// With less redundancy nothing is stated of a standard deviation.
inline constexpr double kLeastRedundancy = 3;

/// The standard deviation of unit weight of control alone, over what is left after each point's three unknowns: of its
/// coordinates and, because these hardly give way when they are stated to be exact, its image measurements; or of the
/// coordinates alone, which many images would hide. 0 with fewer than three points. `setup`: what was adjusted, with
/// the control's sigmas.
[[nodiscard]] double control_misfit(const Block& setup, const Adjusted& adjusted);

/// Whose sigmas to multiply next, and by what: one group of the coordinates of control at a time (plan and height have
/// errors of their own), the surest first, because what is wrong in plan makes the block contradict heights too.
/// `taken`: by what they were multiplied so far. Nothing when none would change by more than a fifth.
[[nodiscard]] std::optional<std::pair<ObservationGroup, double>> next_doubt(const Block& setup,
                                                                            const Adjusted& adjusted,
                                                                            const SigmaFactors& taken);

/// By how much to shift all positions of images [m, in world]: their median difference less the mean difference of
/// control. Errors of positions are mostly common to all, so that control decides the position of the block however
/// weak it is. 0 on an axis where positions or control are missing. `adjusted`: of `setup`.
[[nodiscard]] Eigen::Vector3d position_shift(const Block& setup, const Adjusted& adjusted);
[[nodiscard]] Block with_positions_shifted(Block setup, const Eigen::Vector3d& shift_m);

}  // namespace collinea
