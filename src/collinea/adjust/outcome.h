// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/adjust/free_network.h"
#include "collinea/adjust/normals.h"
#include "collinea/adjust/problem.h"

namespace collinea::bundle {

/// True for an image of Adjusted::images_left_out.
[[nodiscard]] bool is_left_out(const Adjusted& adjusted, ImageId image);

/// Fills everything but the course of the iterations and the covariances, and gives the losses of the problem the
/// information their residuals show: from here on the normal equations stand for what is known. Rays whose point is not
/// seen are no longer counted.
void describe_outcome(const Block& block, const AdjustScope& scope, Problem& problem, const State& state,
                      Adjusted& adjusted);

/// Fills pose, camera and (when wanted) point covariances and reliability, or says what is not determined. Uses up what
/// `normals` holds.
void add_covariances(const Block& block, const Problem& problem, const State& state, const AdjustOptions& options,
                     const Run& run, Normals& normals, Adjusted& adjusted);

/// Fills Adjusted::places, by the selected inverse.
void add_places(const Problem& problem, const State& state, const FreeNetwork& free_network, TileCholesky& inverse,
                const Run& run, Adjusted& adjusted);

/// The cofactor of an observation by one pose and unknowns of the border.
[[nodiscard]] double variance_of(const Row& row, TileCholesky& inverse);

/// Fills Adjusted::camera_pose_correlations, by the selected inverse, when the covariances of poses are there.
void correlate_cameras_and_poses(const Problem& problem, const State& state, TileCholesky& inverse, Adjusted& adjusted);

/// Fills Adjusted::reliability, by the selected inverse.
void add_reliability(const Block& block, const Problem& problem, const State& state, const AdjustOptions& options,
                     TileCholesky& inverse, const Run& run, Adjusted& adjusted);

}  // namespace collinea::bundle
