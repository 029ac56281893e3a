// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <string>

#include "collinea/camera/camera.h"

namespace collinea {

/// How each of Camera::params takes part. 0: held; a standard deviation: observed with it; infinite: free.
using CameraSigmas = std::array<double, Camera::kAllParams>;

/// Those that AdjustOptions::calibration stands for, where `first` is the camera before any adjustment: the weak
/// observations told at adjust(). Nothing when there is no such name.
[[nodiscard]] std::optional<CameraSigmas> calibration_named(const std::string& name, const Camera& first);

/// Whether there is such a name: none, focal, focal_radial, brown, brown_affinity.
[[nodiscard]] bool is_calibration(const std::string& name);

}  // namespace collinea
