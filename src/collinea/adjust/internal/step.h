// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "collinea/adjust/internal/problem.h"
#include "collinea/base/run.h"

namespace collinea::bundle {

/// A step of all unknowns and what came of it.
struct Step {
  std::vector<double> reduced;  ///< 6 of each pose (rotation in the camera frame, centre), then the cameras
  double squared_length = 0;  ///< of `reduced` in the metric of the reduced normal matrix: squared standard deviations
  double promised = 0;        ///< decrease of the cost by the linear model
  double cost = 0;            ///< after the step
  double largest_rotation_rad = 0, largest_move_m = 0;
};

/// Applies step.reduced to images and cameras, moves every point to its best position by the linear model with that
/// damping, and fills the rest of `step`. Answers the state after it.
[[nodiscard]] State moved(const Problem& problem, const State& state, double lambda, Step& step, const Run& run);

}  // namespace collinea::bundle
