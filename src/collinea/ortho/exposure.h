// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "collinea/base/run.h"
#include "collinea/ortho/height_field.h"
#include "collinea/ortho/pixel_cache.h"
#include "collinea/ortho/view.h"

namespace collinea {

/// What makes a picture match its neighbours: colour times gain[c] * exp(falloff[c] * r2), where r2 is the squared
/// distance from the middle of the picture over the squared half diagonal.
struct Exposure {
  std::array<float, 3> gain{1, 1, 1};
  std::array<float, 3> falloff{0, 0, 0};  ///< the same for all pictures of a camera
};

/// By what the three channels of a place of the picture are multiplied.
[[nodiscard]] std::array<float, 3> factor_of(const Exposure& exposure, float relative_radius2);

/// The squared distance of a pixel from the middle of the picture over the squared half diagonal.
[[nodiscard]] double relative_radius2(const Camera& camera, const Eigen::Vector2d& pixel);

/// The colour of a place of the ground in a picture, as natural logarithms.
struct ColourSample {
  std::uint32_t place = 0;
  float r2 = 0;
  std::array<float, 3> log_colour{};
};

/// Gains and fall-off from places seen in several pictures: per pair of pictures the median ratio, then least squares
/// in logarithms over all pairs (Huber weights), drawn towards 1 so that chains of pictures do not drift. `samples[i]`
/// are those of picture i, ascending by place; `cameras[i]` tells which pictures share a fall-off. Pictures without
/// common places keep gain 1.
[[nodiscard]] std::vector<Exposure> balance_exposures(std::span<const std::vector<ColourSample>> samples,
                                                      std::span<const CameraId> cameras);

/// Looks up the places in all pictures (at an eighth of their size) and balances them. Errors: a picture cannot be
/// read; cancelled.
[[nodiscard]] Result<std::vector<Exposure>> exposures_of(const std::vector<View>& views,
                                                         std::span<const Eigen::Vector3d> places_in_world,
                                                         const PixelSource& pixels, const Run& run);

}  // namespace collinea
