// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "collinea/base/result.h"
#include "collinea/models/model_block.h"

namespace collinea {

/// The block or strip as it is concatenated (chain_models(), Mussio 3.3.5), without an adjustment: every model's
/// similarity to the ground, and points as means of the models that show them, with the covariances that follow by
/// propagation of variance from the covariances of all models and of control, along the tree of the chain:
///
///     dp = N^-1 sum A' H (dx known - dx),   N = sum A' H A,   A = [X, -[X]x, I]   for each join and each absolute
///                                                                                  orientation, unweighted
///
/// with increments dp of scale, rotation and translation on the ground, where joins in turn simply add up. To first
/// order: residuals are small beside the models. It is not the best estimate (a join looks at two models alone, and at
/// no weight): sigmas are never smaller than those of join_models().
///
/// Of the members: `models` (tests have residuals alone: observed minus what the mean of the models says, in the
/// model's unit; redundancy and w are NaN), `points`, `control` (differences; sigma of check points), `chain`; sigma0
/// is from the discrepancies of points in several models against what the covariances let them be: their squares over
/// their expectation, NaN without such points. `sigmas_known` false: covariances are multiplied by its square.
/// `unknowns` and `observations` are 0: nothing is adjusted.
///
/// Errors: those of chain_models(). Cost: for each model the models that hang on it, with the square of their points.
[[nodiscard]] Result<JoinedBlock> concatenate_models(const std::vector<StereoModel>& models,
                                                     const std::vector<SurveyedPoint>& control, bool sigmas_known);

}  // namespace collinea
