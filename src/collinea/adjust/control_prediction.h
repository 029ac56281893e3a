// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/adjust/problem.h"
#include "collinea/adjust/tile_cholesky.h"

namespace collinea::bundle {

/// What sigma0 multiplies the covariance of everything adjusted by. The sigmas of a survey are taken as given: sigma0
/// is that of hundreds of thousands of image points, which know nothing of it.
[[nodiscard]] double variance_factor(const Adjusted& adjusted);

/// Covariances of check points and of their differences, with the Cholesky factor of the reduced normal equations: the
/// images' uncertainty with all its correlations, their own measurements, and the survey.
void predict_check_points(const Block& block, const Problem& problem, const State& state, const TileCholesky& factor,
                          const Run& run, Adjusted& adjusted);

/// The same of the control points that took part, with the selected inverse. Their differences are residuals, smaller
/// than their errors: the variance of the survey less that of the adjusted point.
void predict_control_points(const Problem& problem, const State& state, TileCholesky& inverse, Adjusted& adjusted);

}  // namespace collinea::bundle
