// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/adjust/adjust_options.h"
#include "collinea/adjust/internal/normals.h"
#include "collinea/adjust/internal/problem.h"
#include "collinea/base/run.h"

namespace collinea::bundle {

/// The end of a minimisation and its course.
struct Minimum {
  State state;
  double initial_cost = 0, cost = 0;  ///< sums of squares in sigmas, after the losses
  int iterations = 0;
  bool converged = false;
  double last_step_sigmas = 0;  ///< length of the last step of images and cameras, in their standard deviations
};

/// Minimises the sum of squares of all observations by the method of Levenberg and Marquardt: steps (N + lambda D) x =
/// b with the normal matrix N and its diagonal D. The damping lambda follows the gain ratio, the decrease of the cost
/// over what the linear model predicted (Madsen, Nielsen, Tingleff 2004, eq. 2.21): a step that the model predicted
/// well lowers it tenfold, one that it predicted to a hundredth ends it, a step uphill raises it ever faster. After
/// each step the whole block is brought to where its positions, control and verticals want it (settle_gauge). Robust
/// losses are weights at first (iteratively reweighted least squares); once steps gain little, their curvature takes
/// part, since reweighting alone creeps (Triggs et al. 2000, section 4.3).
///
/// The end: the cost hardly falls, the step is short in standard deviations, or images hardly move, as `options` say,
/// and the step was hardly damped: a damped step is short where little determines the block, however far it still has
/// to go. `problem` changes only in its losses.
[[nodiscard]] Minimum minimise(Problem& problem, Normals& normals, State start, const AdjustOptions& options,
                               const Run& run);

/// Brings every point to its best position, images and cameras as they are; nothing changes where the cost would rise.
void settle_points(const Problem& problem, Minimum& found, const Run& run);

}  // namespace collinea::bundle
