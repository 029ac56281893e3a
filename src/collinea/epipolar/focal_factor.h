// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>

#include "collinea/block/features.h"
#include "collinea/camera/camera.h"

namespace collinea {

/// By which factor the focal lengths must be multiplied for the matches of a pair to fit best.
struct FocalFactor {
  double factor = 1;
  double sigma = 0;  ///< standard deviation of its logarithm, from the residuals
};

/// The common factor of the focal lengths whose sigma_f is not 0, from the verified matches of a general pair. One pair
/// says little (the optical axes may meet, the motion may be forward): combine many, weighted by 1 / sigma^2 or by a
/// median. Nothing when the pair is not kGeneral with a motion, both focal lengths are fixed, or the factor is not
/// determined (sigma > 0.3) or beyond [0.3, 3].
[[nodiscard]] std::optional<FocalFactor> focal_factor(const Camera& camera_first, std::span<const Keypoint> first,
                                                      const Camera& camera_second, std::span<const Keypoint> second,
                                                      const ImagePair& pair);

}  // namespace collinea
