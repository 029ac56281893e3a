// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/marking/marking_block.h"

namespace collinea {

/// Two images that show a place, and how well they measure its height.
struct StereoChoice {
  std::array<ImageId, 2> images;         ///< the left one first (StereoGeometry)
  double base_to_height = 0;             ///< base over the mean depth of the place
  double convergence_rad = 0;            ///< angle between the two rays
  std::array<double, 2> gsd_m{};         ///< size of a pixel at the place, across its ray
  std::optional<double> sigma_height_m;  ///< with marks of kPointing_px in both; nothing: poses are not known
  double from_middle = 0;                ///< of the place in the two images, the larger: 0 in the middle, 1 at the rim
  bool is_hidden = false;                ///< by the surface, in one of them
};

/// Of a person who sets the floating mark, in each photograph.
inline constexpr double kPointing_px = 0.5;
/// What can be seen in stereo. Eyes fuse what differs little: beyond 30 degrees walls and trees look too different from
/// the two sides (base to height of 0.54); below 2 degrees a pixel is 30 pixels of height. Of images
/// that differ in scale by more than kMostScale the coarser one decides, and the other is wasted.
inline constexpr double kLeastConvergence_rad = 0.035, kMostConvergence_rad = 0.52, kMostScale = 1.6;
/// Of the size of an image: nearer to its rim there is too little around the place.
inline constexpr double kRim = 0.05;
inline constexpr std::size_t kMostStereoChoices = 24;

/// The pairs that show a place, the best first: those that nothing hides before those that something does, and of these
/// by the standard deviation of the height, from the intersection of both rays,
///
///     C = (B'WB)^-1 + G A C_poses A'G',    G = (B'WB)^-1 B'W
///
/// with B, A the derivatives of the pixels by point and poses, and C_poses of local_poses(); where the poses have no
/// covariance by (B'WB)^-1 alone. Of pairs that are equal within kEqualSigma, which nobody notices, the one comes first
/// that has most around the place: least from_middle. Among the kMostSeen images that are nearest to the place. At most
/// kMostStereoChoices. Empty: no two images show it so.
[[nodiscard]] std::vector<StereoChoice> stereo_choices(const MarkingBlock& block,
                                                       const Eigen::Vector3d& position_in_world);
inline constexpr std::size_t kMostSeen = 14;
inline constexpr double kEqualSigma = 1.1;

/// The same of two images, whatever their convergence. Errors: not oriented; the place is not in both.
[[nodiscard]] Result<StereoChoice> stereo_choice(const MarkingBlock& block, ImageId one, ImageId other,
                                                 const Eigen::Vector3d& position_in_world);

}  // namespace collinea
