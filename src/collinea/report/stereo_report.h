// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "collinea/base/words.h"
#include "collinea/camera/camera.h"
#include "collinea/dense/level_matching.h"
#include "collinea/geometry/rigid3.h"

namespace collinea {

/// What the coordinates of a cloud of a single pair are in: x right, y down, z forward of its left camera; or the world
/// of its orientation.
enum class PairFrame : std::uint8_t { kLeftCamera, kWorld };

/// How disparities are found.
enum class StereoMatcher : std::uint8_t { kDense, kLocal, kLevels };
inline constexpr Word<StereoMatcher> kStereoMatcherWords[] = {
    {StereoMatcher::kDense, "dense", "semi-global matching: every pixel, smooth where costs do not say"},
    {StereoMatcher::kLocal, "local", "every pixel by its own window: the most alike wins"},
    {StereoMatcher::kLevels, "levels", "interest points of falling threshold, each level guided by the last (Karfis)"},
};
constexpr std::span<const Word<StereoMatcher>> words(StereoMatcher) { return kStereoMatcherWords; }

/// What came of matching a single pair.
struct StereoReport {
  StereoMatcher matcher{};
  int min_disparity_px = 0, max_disparity_px = 0;  ///< searched
  std::size_t pixels = 0;                          ///< of the left image that show anything
  std::size_t measured = 0;                        ///< of these with a disparity
  std::optional<double> median_sigma_px;           ///< of those that have one
  std::vector<LevelCount> levels;                  ///< where the matcher has them
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
