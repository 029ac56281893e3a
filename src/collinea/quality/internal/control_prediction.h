// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/adjust/solved.h"
#include "collinea/math/tile_cholesky.h"
#include "collinea/quality/internal/free_network.h"

namespace collinea::bundle {

/// Covariances of check points and of their differences, with the Cholesky factor of the reduced normal equations: the
/// images' uncertainty with all its correlations, their own measurements, and the survey. sigma0 multiplies what was
/// adjusted; the sigmas of a survey are taken as given: sigma0 is that of image points, which know nothing of it.
void predict_check_points(const Solved& solved, const TileCholesky& factor, const FreeNetwork& free_network,
                          const Run& run, Adjusted& adjusted);

/// The same of the control points that took part, and of check points that did without their coordinates, with the
/// selected inverse. Their differences are residuals, smaller than their errors: the variance of the survey less that
/// of the adjusted point.
void predict_control_points(const Solved& solved, TileCholesky& inverse, const FreeNetwork& free_network,
                            Adjusted& adjusted);

}  // namespace collinea::bundle
