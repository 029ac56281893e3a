// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <set>
#include <vector>

#include "collinea/base/finding.h"
#include "collinea/block/block.h"

namespace collinea {

/// What was found and what should be done about it before the block is adjusted.
struct ControlDiagnosis {
  std::vector<Finding> findings;                ///< codes kControlMeasurement to kPositionCrs
  std::set<std::size_t> excluded_observations;  ///< indices in Block::control_observations
  std::set<ControlId> excluded_points;
  double position_height_shift_m = 0;  ///< to be added to the heights of Image::position
  bool positions_unusable = false;     ///< they and the control cannot both be right: adjust without positions
  bool axes_swapped = false;           ///< read the control again with eastings and northings exchanged
};

}  // namespace collinea
