// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <optional>
#include <vector>

#include "collinea/math/robust.h"

namespace collinea {

/// How precisely the images of tie points are measured: size and shape of their errors.
struct TieNoise {
  double sigma_px = 0.5;  ///< of each coordinate of a feature found at a scale of 2 px; others times sigma_factor
  Loss::Kind loss = Loss::kHuber;  ///< the shape, as AdjustOptions::loss has it
  double loss_scale_sigmas = 2;
  /// Errors beyond are gross: no part of this distribution. Infinite where nothing tells.
  double gross_sigmas = std::numeric_limits<double>::infinity();
  /// The same of rays measured anew, over the standard deviations that their windows state.
  double anew_factor = 1, anew_gross_sigmas = std::numeric_limits<double>::infinity();
};

/// How the standard deviation of a feature's position grows with the scale it was found at, relative to 2 px. Two
/// errors add up: that of the pixels (noise, sampling), the same for all, and one that grows with the feature, because
/// what surrounds the point looks different from elsewhere.
[[nodiscard]] double sigma_factor(double scale_px);

/// Fits a Student distribution in two dimensions to the squared lengths of errors (in units of sigma_factor^2 px^2,
/// free of the part that fitting the points took): its scale and its degrees of freedom, between 2 and 20, by maximum
/// likelihood. Answers it as loss: Cauchy's with k^2 = nu + 2, sigma^2 = nu / (nu + 2) of the squared scale. Gross is
/// what one of a thousand of its errors exceeds. Nothing with fewer than 100 errors, or when most of them
/// are zero. After Lange, Little and Taylor (1989).
[[nodiscard]] std::optional<TieNoise> fit_noise(const std::vector<double>& squared_px2);

}  // namespace collinea
