// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/orient/reconstruction.h"

namespace collinea {

/// Orients as many images as hang together: an initial pair with parallax and support, then image after image by
/// resection, intersection of new points, local and, at growing intervals, global adjustment with self-calibration and
/// rejection of bad rays. The result lies in an arbitrary gauge. Where images are in place already, growth goes on from
/// them. Images given in `exclude` stay out. Nothing was
/// oriented: an empty reconstruction. After Schoenberger & Frahm (2016), Structure-from-motion revisited; without their
/// camera-specific retriangulation.
[[nodiscard]] Result<> grow(Reconstruction& reconstruction, std::span<const ImagePair> pairs,
                            const std::set<ImageId>& exclude, const OrientOptions& options, const Run& run);

/// Global adjustment, rejection of bad rays and intersection of what was left, until little changes.
[[nodiscard]] Result<Adjusted> settle(Reconstruction& reconstruction, const AdjustScope& scope,
                                      const OrientOptions& options, const Run& run);

/// How many camera parameters a block of so many images carries: a word for AdjustOptions::calibration.
[[nodiscard]] std::string calibration_for(const OrientOptions& options, std::size_t images);

}  // namespace collinea
