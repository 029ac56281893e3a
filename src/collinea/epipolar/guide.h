// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "collinea/block/features.h"
#include "collinea/camera/camera.h"
#include "collinea/epipolar/two_view.h"

namespace collinea {

/// For each keypoint of the first image those of the second that lie near its epipolar line, or near its position:
/// candidates[begin[i]] to candidates[begin[i + 1] - 1], each once.
struct Guide {
  std::vector<std::uint32_t> begin;  ///< one more than keypoints
  std::vector<std::uint32_t> candidates;
};

/// The guide that verified matches of some of the keypoints give to all of them: within twice the largest error of a
/// match from the epipolar line of a kGeneral pair, or from where the homography of a kPlanar pair maps the keypoint.
/// Nothing for other pairs, when the matches are too few to fix the relation well, or when more than a few of a kPlanar
/// pair are off the plane.
[[nodiscard]] std::optional<Guide> guide(const Camera& camera_first, std::span<const Keypoint> first,
                                         const Camera& camera_second, std::span<const Keypoint> second,
                                         const ImagePair& verified, const VerifyOptions& options);

}  // namespace collinea
