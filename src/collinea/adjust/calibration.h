// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "collinea/camera/calibration_choice.h"
#include "collinea/camera/camera.h"

namespace collinea {

/// How each of Camera::params takes part. 0: fixed; a standard deviation: observed with it; infinite: free.
using CameraSigmas = std::array<double, Camera::kAllParams>;

/// Those that a calibration stands for, where `first` is the camera before any adjustment: the pseudo-observations
/// stated at adjust().
[[nodiscard]] CameraSigmas calibration_sigmas(Calibration calibration, const Camera& first);

}  // namespace collinea
