// SPDX-License-Identifier: Apache-2.0
#pragma once

// What depth maps and single pairs make of correlations (docs/theory/dense.md, "Measurement").
namespace collinea::dense {

/// Standard deviations by correlation are multiplied by this: fitted to rendered images where noise decides.
inline constexpr float kSigmaScale = 1.2f;
inline constexpr float kSigmaFloorPx = 0.05f;   ///< stands for errors of interpolation, which are not random
inline constexpr float kSmoothSigmaPx = 0.25f;  ///< what the regularised surface is worth

}  // namespace collinea::dense
