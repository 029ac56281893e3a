// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <vector>

#include "collinea/quality/examine.h"

namespace collinea {

/// The set of that name of kAdditionalNames. Error: none has it.
[[nodiscard]] Result<AdditionalSet> additional_named(const std::string& name);

/// Gives every camera that is calibrated the additional parameters of that name (kAdditionalNames). Answers the
/// standard deviations of all its parameters before the adjustment; of no camera, where calibration is "none". Error:
/// no such set.
[[nodiscard]] Result<std::map<CameraId, CameraSigmas>> add_additional(const std::string& name,
                                                                      const std::string& calibration,
                                                                      std::map<CameraId, Camera>& cameras);

/// How many of them are there for a reason, a line for each camera.
[[nodiscard]] std::vector<std::string> additional_findings(const Block& block, const Examined& adjusted);

}  // namespace collinea
