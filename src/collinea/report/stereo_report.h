// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "collinea/camera/camera.h"
#include "collinea/geometry/rigid3.h"

namespace collinea {

/// What the coordinates of a cloud of a single pair are in: x right, y down, z forward of its left camera; or the world
/// of its orientation.
enum class PairFrame : std::uint8_t { kLeftCamera, kWorld };

/// What came of matching a single pair.
struct StereoReport {
  int min_disparity_px = 0, max_disparity_px = 0;  ///< searched
  std::size_t pixels = 0;                          ///< of the left image that show anything
  std::size_t measured = 0;                        ///< of these with a disparity
  double median_sigma_px = 0;                      ///< of the disparities; 0: there are none
  PairFrame frame{};                               ///< of the cloud

  /// The epipolar pair, where the cameras are known.
  struct Cameras {
    Camera left, right;
    Rigid3 left_from_world;
    double base_m = 0;
    std::size_t points = 0;  ///< of the cloud
  };
  std::optional<Cameras> cameras;
};

[[nodiscard]] std::string stereo_json(const StereoReport& report);
[[nodiscard]] std::string stereo_text(const StereoReport& report);  ///< the gist, for a terminal

}  // namespace collinea
