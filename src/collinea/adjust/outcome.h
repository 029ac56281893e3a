// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/adjust/normals.h"
#include "collinea/adjust/problem.h"

namespace collinea::bundle {

/// Fills everything but the course of the iterations and the covariances.
void describe_outcome(const Block& block, const AdjustScope& scope, const Problem& problem, const State& state,
                      Adjusted& adjusted);

/// Fills pose, camera and (when wanted) point covariances and reliability, or says what is not determined. Uses up what
/// `normals` holds.
void add_covariances(const Block& block, const Problem& problem, const State& state, const AdjustOptions& options,
                     const Run& run, Normals& normals, Adjusted& adjusted);

/// Fills Adjusted::reliability, by the selected inverse.
void add_reliability(const Block& block, const Problem& problem, const State& state, const AdjustOptions& options,
                     TileCholesky& inverse, const Run& run, Adjusted& adjusted);

}  // namespace collinea::bundle
