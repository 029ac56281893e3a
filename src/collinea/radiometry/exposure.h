// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "collinea/base/run.h"
#include "collinea/radiometry/internal/channel_table.h"
#include "collinea/radiometry/view.h"
#include "collinea/raster/pixel_cache.h"

namespace collinea {

/// What makes an image match its neighbours: colour times gain[c] * exp(falloff[c] * r2), where r2 is the squared
/// distance from the middle of the image over the squared half diagonal.
struct Exposure {
  std::array<float, 3> gain{1, 1, 1};
  std::array<float, 3> falloff{0, 0, 0};  ///< the same for all images of a camera

  template <class Visit>
  static void fields(Visit&& visit) {
    visit("gain", &Exposure::gain);
    visit("falloff", &Exposure::falloff);
  }
};

/// What makes the images of a block match.
struct ColourBalance {
  std::vector<Exposure> exposures;  ///< of each view
  /// How much darker the ground looks from a direction than from the mean of all, as natural logarithms over the
  /// horizontal components of the unit vector from the ground to the camera. Ground reflects more light back to the
  /// sun (the hot spot round the shadow of the camera) than away from it.
  ChannelTable directions;
  /// The mean of `directions` over the images that show a point neither cut off nor black, over x and y of the world.
  /// The colour of a point is that mean of what is seen of it: at the border of the block, which all see from the same
  /// side, it stays what the images show.
  ChannelTable mean_darkness;

  /// By what the channels of an image are multiplied where it shows `position_in_world` at `pixel`.
  [[nodiscard]] std::array<float, 3> factor(std::size_t view_index, const View& view,
                                            const Eigen::Vector3d& position_in_world,
                                            const Eigen::Vector2d& pixel) const;

  template <class Visit>
  static void fields(Visit&& visit) {
    visit("exposures", &ColourBalance::exposures);
    visit("directions", &ColourBalance::directions);
    visit("mean_darkness", &ColourBalance::mean_darkness);
  }
};

/// The squared distance of a pixel from the middle of the image over the squared half diagonal.
[[nodiscard]] double relative_radius2(const Camera& camera, const Eigen::Vector2d& pixel);

/// The colour of a point of the ground in an image, as natural logarithms.
struct ColourSample {
  std::uint32_t position_index = 0;
  float r2 = 0;
  std::array<float, 3> log_colour{};
  Eigen::Vector2d direction = Eigen::Vector2d::Zero();  ///< horizontal part of the unit vector from point to camera
};

/// The camera of an image, and where in plan it was taken.
struct Standpoint {
  CameraId camera;
  Eigen::Vector2d at;
};

/// Gains, fall-off and brightness of directions from points seen in several images: least squares in logarithms with
/// robust weights. A trend of the exposures over the block and a trend of the brightness with the direction explain the
/// same differences between neighbours; the second is taken, because exposures have no reason to follow the ground, and
/// gains that do would pile up to a cast at the border of the block. `positions`: in plan; `samples[i]` are those of
/// image i, ascending by position_index; images with the same `standpoints[i].camera` share a fall-off. Images without
/// common points keep gain 1. Error: cancelled.
[[nodiscard]] Result<ColourBalance> balance_exposures(std::span<const Eigen::Vector2d> positions,
                                                      std::span<const std::vector<ColourSample>> samples,
                                                      std::span<const Standpoint> standpoints, const Run& run);

/// Looks up the points in all images (at an eighth of their size) and balances them. Errors: an image cannot be
/// read; cancelled.
[[nodiscard]] Result<ColourBalance> balance_of(const std::vector<View>& views,
                                               std::span<const Eigen::Vector3d> positions_in_world,
                                               const PixelSource& pixels, const Run& run);

}  // namespace collinea
