// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "collinea/camera/calibration_choice.h"
#include "collinea/camera/camera.h"

namespace collinea {

/// How each of Camera::params takes part. 0: fixed; a standard deviation: observed with it; infinite: free.
using CameraSigmas = std::array<double, Camera::kAllParams>;

/// Those that a calibration stands for, where `first` is the camera before any adjustment: the pseudo-observations
/// stated at adjust().
[[nodiscard]] CameraSigmas calibration_sigmas(Calibration calibration, const Camera& first);

/// Parameters of the model that a set of additional parameters spans by itself: b1, b2, p1, p2 and with cubic functions
/// k1 (not of kFourier, which is no polynomial).
[[nodiscard]] std::vector<int> spanned_by(AdditionalSet set);

}  // namespace collinea
