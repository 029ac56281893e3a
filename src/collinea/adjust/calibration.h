// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "collinea/base/words.h"
#include "collinea/camera/camera.h"

namespace collinea {

/// Sets of camera parameters that an adjustment may find.
enum class Calibration : std::uint8_t { kNone, kFocal, kFocalRadial, kBrown, kBrownAffinity };

inline constexpr Word<Calibration> kCalibrationWords[] = {
    {Calibration::kNone, "none"},
    {Calibration::kFocal, "focal"},
    {Calibration::kFocalRadial, "focal_radial", "f k1 k2"},
    {Calibration::kBrown, "brown", "f cx cy k1 k2 k3 p1 p2, of a fisheye k4"},
    {Calibration::kBrownAffinity, "brown_affinity", "and b1 b2"},
};
[[nodiscard]] constexpr std::span<const Word<Calibration>> words(Calibration) { return kCalibrationWords; }

/// How each of Camera::params takes part. 0: held; a standard deviation: observed with it; infinite: free.
using CameraSigmas = std::array<double, Camera::kAllParams>;

/// Those that a calibration stands for, where `first` is the camera before any adjustment: the weak observations told
/// at adjust().
[[nodiscard]] CameraSigmas calibration_sigmas(Calibration calibration, const Camera& first);

}  // namespace collinea
