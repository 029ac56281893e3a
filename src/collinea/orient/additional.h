// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <vector>

#include "collinea/quality/examine.h"

namespace collinea {

/// Gives every camera that is calibrated this set of additional parameters. Returns the standard deviations of all its
/// parameters before the adjustment; of no camera, where nothing is calibrated.
[[nodiscard]] std::map<CameraId, CameraSigmas> add_additional(AdditionalSet set, Calibration calibration,
                                                              std::map<CameraId, Camera>& cameras);

/// How many of them are there for a reason, a line for each camera.
[[nodiscard]] std::vector<Finding> additional_findings(const Block& block, const Examined& adjusted);

}  // namespace collinea
