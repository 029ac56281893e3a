// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include "collinea/block/block.h"
#include "collinea/block/features.h"
#include "collinea/quality/examine.h"

namespace collinea {

/// What makes an oriented block weaker than its residuals look:
///   - motion along the view: rays meet at small angles
///   - rolling shutter: the camera turned while images were read out, see line_motion
///   - repeated structure: pairs that agree among themselves but not with the block
///   - a critical surface: tie points and projection centres on one ruled quadric, where another block fits as well
///     (Krames 1941, Maybank 1993)
[[nodiscard]] std::vector<Finding> weak_cases(const Block& oriented, std::span<const ImagePair> pairs);

/// Cameras whose focal length the images hardly determine, with the cause: flat scene, motion along the view, few
/// images. `first_cameras`: before adjustment; `adjusted` belongs to `oriented`, with covariances of cameras.
[[nodiscard]] std::vector<Finding> weak_focals(const Block& oriented, const std::map<CameraId, Camera>& first_cameras,
                                               const Examined& adjusted);

/// Cameras whose focal length came out farther from its start than the source of that allows: more than three of its
/// standard deviations (of EXIF 5 %, of a calibration those it states). Not where it was only assumed.
[[nodiscard]] std::vector<Finding> moved_focals(const std::map<CameraId, Camera>& first_cameras,
                                                const Adjusted& adjusted);

/// That no two images could start a block, and why: no overlap, one position of exposure (panorama), or too little
/// parallax.
[[nodiscard]] Error nothing_fits(std::span<const ImagePair> pairs);

}  // namespace collinea
