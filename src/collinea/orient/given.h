// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>

#include "collinea/orient/orient.h"

namespace collinea {

/// Cameras and poses that come from another program.
struct GivenOrientation {
  std::map<ImageId, Rigid3> cam_from_world;
  std::map<CameraId, Camera> cameras;  ///< none: the source knows no cameras; they are calibrated on its poses
  bool in_world = false;               ///< the poses are in the block's world frame, and that is a place on Earth
  std::string source;                  ///< file or folder, for people
};

/// Intersects the tie points of the pairs with the poses as they are given; images without a pose stay out. With
/// options.refine_orientation the block is then adjusted (and options.remeasure followed) as one that was grown here.
/// Without, poses stay as they are, up to one similarity that brings a model from an arbitrary frame to the map, by
/// positions or control; a model that agrees with these as it lies is left there, and control is then only compared.
/// Control that fixed the similarity counts as used. Errors: no pose, no tie point; cancelled.
[[nodiscard]] Result<Orientation> orient_as_given(const Block& setup, std::span<const ImagePair> pairs,
                                                  const KeypointSource& keypoints, const GivenOrientation& given,
                                                  const OrientOptions& options, const Run& run,
                                                  const PictureSource& pictures = {});

/// Whether poses agree with three and more control points, or else with the positions of their images, as they lie:
/// the median difference is below five standard deviations.
[[nodiscard]] bool lies_in_world(const Block& block);

}  // namespace collinea
