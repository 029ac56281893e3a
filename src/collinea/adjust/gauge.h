// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/adjust/internal/problem.h"

namespace collinea::bundle {

using Matrix37 = Eigen::Matrix<double, 3, 7>;

/// The projection centre of an image.
[[nodiscard]] inline Eigen::Vector3d centre_in(const State& state, std::size_t image) {
  return Eigen::Map<const Eigen::Vector3d>(state.frames[image].data() + 9);
}

/// How a point moves when its world is shifted, turned and scaled about `centre`, divided by `size`:
/// by [shift / size, angles (rad), log scale].
[[nodiscard]] Matrix37 motion_of(const Eigen::Vector3d& point, const Eigen::Vector3d& centre, double size);

/// Shifts, turns and scales the block as a whole so that positions, verticals, control coordinates and what was
/// measured on the ground fit best; image residuals stay as they are. Orientations of set-ups and common heights go
/// with it. A linear step does that badly: precise rays resist a turn by its second-order error, so that a block that
/// lies askew creeps home. Answers by how much the cost fell; 0 and nothing done where it does not, and unless
/// problem.moves_as_one.
double settle_gauge(const Problem& problem, State& state);

}  // namespace collinea::bundle
