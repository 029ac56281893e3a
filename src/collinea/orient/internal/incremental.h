// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/orient/internal/reconstruction.h"

namespace collinea {

/// First damping of the adjustment of a whole block that is near its minimum: what bends it as a whole, which hardly
/// any residual sees, must not be held back.
inline constexpr double kSettledDamping = 1e-8;

/// Orients as many images as hang together: an initial pair with parallax and support, then image after image by
/// resection, intersection of new points, local and, at growing intervals, global adjustment with self-calibration and
/// rejection of bad rays. The result lies in an arbitrary gauge. Where images are oriented already, growth goes on from
/// them. Images given in `exclude` stay out. Nothing was
/// oriented: an empty reconstruction. After Schoenberger & Frahm (2016), Structure-from-motion revisited; without their
/// camera-specific retriangulation.
[[nodiscard]] Result<> grow(Reconstruction& reconstruction, std::span<const ImagePair> pairs,
                            const std::set<ImageId>& exclude, const OrientOptions& options, const Run& run);

/// Whether a pair of images outside `exclude` is worth a try as the start of a block.
[[nodiscard]] bool can_start(std::span<const ImagePair> pairs, const std::set<ImageId>& exclude);

/// How a grown block is adjusted: with the noise its tie points have and, from three images on, with all camera
/// parameters: a parameter that is fixed counts as exactly known, and f with its sigma pays for what it really is.
[[nodiscard]] AdjustOptions settled_options(const Reconstruction& reconstruction, const OrientOptions& options);

/// Global adjustment, rejection of bad rays and intersection of what was left, until little changes; images that keep
/// fewer than min_points rays are given up, as resection would not have taken them. With `learn_noise` size and shape
/// of the tie points' errors are taken from what they show. Coarse: to 1e-4 of the cost. Error: no two images are left.
[[nodiscard]] Result<Adjusted> settle(Reconstruction& reconstruction, const AdjustScope& scope,
                                      const OrientOptions& options, bool learn_noise, const Run& run);

}  // namespace collinea
