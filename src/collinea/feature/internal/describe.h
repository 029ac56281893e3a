// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>

#include "collinea/block/features.h"
#include "collinea/feature/internal/sift_kernels.h"

namespace collinea {

/// Up to three directions [rad, from x to y, in [0, 2 pi)], the most distinct first.
struct MainDirections {
  static constexpr std::size_t kMost = 3;

  std::array<float, kMost> angle_rad{};
  std::size_t count = 0;
};

/// The directions in which the gradients round a position point most (Lowe 2004, section 5): the peaks of their
/// histogram that reach 0.8 of the highest. x, y: pixel indices; blur_px: of the feature. None where the image is
/// constant.
[[nodiscard]] MainDirections main_directions(const BlurredImage& image, float x, float y, double blur_px);

/// The RootSIFT descriptor of a position; see sift.h. It is the mean over three sizes of patch (domain-size pooling,
/// Dong and Soatto 2015; here on one level of blur), which finds one match in ten more between distant views.
[[nodiscard]] Descriptor describe_patch(const BlurredImage& image, float x, float y, double blur_px, float angle_rad);

/// Makes a descriptor of a gradient histogram: limits single values (Lowe 2004, section 6.1) and takes the square root.
[[nodiscard]] Descriptor root_descriptor(std::array<float, 128> histogram);

}  // namespace collinea
