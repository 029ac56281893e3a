// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

#include "collinea/block/features.h"
#include "collinea/camera/camera.h"
#include "collinea/epipolar/internal/verify_options.h"

namespace collinea {

/// max_error_px for the size of these images.
[[nodiscard]] double largest_error_px(const Camera& first, const Camera& second, const VerifyOptions& options);

/// What two images have to do with each other, from putative matches between their keypoints (Match indexes into both
/// spans). The answer's image ids are left empty for the caller to fill in.
///   - An essential matrix is looked for (five_point, Sampson error); when a focal length is merely assumed (sigma_f >
///     0.1 f) a fundamental matrix first. `matches` are those within max_error_px of it and in front of both cameras.
///   - A homography and a rotation compete with it by the information criterion of Torr (GRIC, IJCV 2002): kPlanar when
///     a plane explains the matches as well, kRotation when a turn about the projection centre does (within the
///     uncertainty of the focal length).
///   - kNone: fewer than min_inliers, fewer than chance would bring together (a-contrario bound of Moisan and Stival,
///     IJCV 2004), all on one line, or nearly all at the same pixel in both images. Matches of marks that are in
///     every image (watermark, date, dirt on the sensor; see without_marks) are left out beforehand.
/// second_from_first is given (unit translation) for kGeneral and kPlanar when the essential matrix holds; otherwise
/// its translation is zero (for kRotation the rotation is given). A plane alone leaves two motions; the one that more
/// matches support is given. With an assumed focal length the motion belongs to the factor of it that fits best.
[[nodiscard]] ImagePair verify(const Camera& camera_first, std::span<const Keypoint> first, const Camera& camera_second,
                               std::span<const Keypoint> second, std::span<const Match> putative,
                               const VerifyOptions& options, std::uint64_t seed);

}  // namespace collinea
