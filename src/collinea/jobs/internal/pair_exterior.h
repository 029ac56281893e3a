// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>

#include "collinea/jobs/internal/exterior_table.h"
#include "collinea/jobs/internal/pair_control.h"

namespace collinea {

/// The relative orientation that the model has, as its command reports it: all points of it in pixels of the files,
/// model coordinates with the axes of photographs, of that base or of the base 1.
[[nodiscard]] RelativeReport relative_report_of(const PairOrientation& last, const PairFiles& pair,
                                                const RelativeOptions& options, std::optional<double> base_m,
                                                bool is_given);

/// Both exterior orientations: on the ground, or without control in the model with x right, y up, z backwards, where
/// the left image is the datum. With x the change of the relative orientation, of covariance C, and t the similarity to
/// the ground, of covariance T for a given model, covariance = B C B' + J T J' as of points of the surface
/// (PairOrientationSigma): B holds what a change does by way of the control. Errors: an orientation one standard
/// deviation away cannot be made.
[[nodiscard]] Result<std::array<UncertainPose, 2>> exterior_poses(const ModelOfPair& model,
                                                                  const std::optional<PairControl>& control,
                                                                  const std::optional<AbsoluteOrientation>& absolute);

/// As tables have them.
[[nodiscard]] std::array<PairExterior, 2> pair_exterior(const std::array<UncertainPose, 2>& poses,
                                                        const PairFiles& pair, bool is_metric);

}  // namespace collinea
