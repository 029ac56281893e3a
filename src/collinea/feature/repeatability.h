// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "collinea/feature/interest.h"

namespace collinea {

enum class ImageChange : std::uint8_t {
  kRotation,  ///< about the middle [deg], clockwise on the image
  kScale,     ///< size after it beside before
  kNoise,     ///< standard deviation of the normal noise added to each pixel [grey levels]
};
inline constexpr Word<ImageChange> kImageChangeWords[] = {
    {ImageChange::kRotation, "rotation"}, {ImageChange::kScale, "scale"}, {ImageChange::kNoise, "noise"}};
[[nodiscard]] constexpr std::span<const Word<ImageChange>> words(ImageChange) { return kImageChangeWords; }

/// An image as it looks after a change, and where each pixel has gone.
struct ChangedImage {
  GreyImage image;
  Eigen::Matrix3d from_original;  ///< homogeneous pixel coordinates
};

/// Renders a change: bicubic (Keys 1981, a = -1/2), behind a Gaussian that removes what a smaller image cannot hold. A
/// rotated image has the size of the original; outside it the original is mirrored. Noise from `seed` alone.
[[nodiscard]] ChangedImage changed(const GreyImage& image, ImageChange change, double amount, std::uint64_t seed);

struct Repeatability {
  std::size_t first = 0, second = 0;  ///< points that lie in the part that both images show
  std::size_t repeated = 0;           ///< pairs of them within the tolerance, one to one, nearest first
  double rms_px = 0;                  ///< distance of the pairs, in the second image

  /// Pairs beside the smaller of both numbers (Schmid, Mohr and Bauckhage 2000); 0 without points.
  [[nodiscard]] double rate() const;
  /// Pairs beside the points of the second image (Karfis 2.1).
  [[nodiscard]] double rate_of_second() const;
};

/// The sizes of two images, and what both must show around a point for it to count.
struct CommonPart {
  int first_width = 0, first_height = 0, second_width = 0, second_height = 0;
  double border_px = 0;
};

/// How many points of one image are found again in another that a homography leads to.
[[nodiscard]] Repeatability repeatability(std::span<const InterestPoint> first, std::span<const InterestPoint> second,
                                          const Eigen::Matrix3d& second_from_first, const CommonPart& part,
                                          double tolerance_px);

}  // namespace collinea
