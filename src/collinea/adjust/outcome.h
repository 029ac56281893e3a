// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/adjust/adjust_scope.h"
#include "collinea/adjust/adjusted.h"
#include "collinea/adjust/internal/problem.h"

namespace collinea::bundle {

/// True for an image of Adjusted::images_left_out.
[[nodiscard]] bool is_left_out(const Adjusted& adjusted, ImageId image);

/// Fills everything but the course of the iterations and the covariances, and gives the losses of the problem the
/// information their residuals show: from here on the normal equations stand for what is known. Rays whose point is not
/// seen are no longer counted.
void describe_outcome(const Block& block, const AdjustScope& scope, Problem& problem, const State& state,
                      Adjusted& adjusted);

}  // namespace collinea::bundle
