// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "collinea/orient/internal/reconstruction.h"
#include "collinea/quality/variance_components.h"

namespace collinea {

/// Adjustment of a grown block as it stands: one step away from its minimum, see kSettledDamping.
[[nodiscard]] Result<Adjusted> adjust_settled(Reconstruction& part, const AdjustScope& scope,
                                              const OrientOptions& options, const Run& run);

/// The same with covariances of control points.
[[nodiscard]] Result<Adjusted> examine_settled(Reconstruction& part, const AdjustScope& scope,
                                               const OrientOptions& options, const Run& run);

/// A block adjusted with positions and control, and how far these were not as good as stated.
struct ControlAdjustment {
  Adjusted adjusted;
  SigmaFactors sigma_factors = as_given();    ///< what the given sigmas of control were multiplied by
  Eigen::Vector3d position_shift_m{0, 0, 0};  ///< what was added to the positions of images
  std::vector<Finding> findings;
};

/// Adjusts a block that lies in the world with positions and control. Standard deviations that the block contradicts by
/// many times are replaced by those that control shows: of its image measurements, by how far the rays to a point miss
/// each other; then of its coordinates, plan and height apart, from adjustment to adjustment, the positions shifted to
/// where control puts the block. (Shifts that are unknowns of the adjustment are left to it.) What is found goes to the
/// setup of the part, too. Errors: as settle().
[[nodiscard]] Result<ControlAdjustment> adjust_with_control(Reconstruction& part, const AdjustScope& scope,
                                                            bool shift_is_unknown, const OrientOptions& options,
                                                            const Run& run);

}  // namespace collinea
