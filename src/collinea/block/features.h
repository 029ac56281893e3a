// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "collinea/base/id.h"
#include "collinea/geometry/rigid3.h"

namespace collinea {

/// A detected feature. Pixel convention: the centre of the upper-left pixel is (0.5, 0.5).
struct Keypoint {
  float x = 0, y = 0;   ///< [px]
  float scale_px = 0;   ///< standard deviation of the blur it was found at
  float angle_rad = 0;  ///< main gradient direction, from x to y (clockwise on the image)
  float strength = 0;   ///< the detector's response, in part beside that of the region; larger is stronger
};

using Descriptor = std::array<std::uint8_t, 128>;  ///< RootSIFT, L2 norm about 512, at most 127: see feature/sift.h

/// The features of one image, strongest first.
struct Features {
  std::vector<Keypoint> keypoints;
  std::vector<Descriptor> descriptors;
};

/// Feature i of the first image and feature j of the second show the same point.
using Match = std::pair<std::uint32_t, std::uint32_t>;

/// What two images turned out to have to do with each other.
enum class PairGeometry : std::uint8_t {
  kNone,      ///< no geometry explains enough matches
  kGeneral,   ///< essential or fundamental matrix with parallax
  kPlanar,    ///< a plane (homography) explains as much: structure is flat, or there is hardly a base
  kRotation,  ///< the same centre: no parallax
};

/// Verified matches of two images, first < second.
struct ImagePair {
  ImageId first, second;
  PairGeometry geometry = PairGeometry::kNone;
  std::vector<Match> matches;      ///< inliers only, sorted
  Rigid3 second_from_first;        ///< when kGeneral or kPlanar with a decomposition: translation of unit length
  double median_parallax_rad = 0;  ///< median angle between the rays of the inliers
  int putative = 0;                ///< matches before verification
};

}  // namespace collinea
