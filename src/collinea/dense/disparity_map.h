// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "collinea/raster/raster.h"

namespace collinea {

/// How unlike two pixels of a pair are. Census is the one to use; the others are there to be compared with it.
enum class StereoCost : std::uint8_t { kCensus, kZncc, kRank, kSad, kSsd };
inline constexpr std::array<std::string_view, 5> kStereoCostNames = {"census", "zncc", "rank", "sad", "ssd"};

/// Disparities to search, both ends included [px]: column in the left picture less column in the right one.
struct DisparityRange {
  int low = 0, high = 63;
};

/// What the left picture sees, pixel by pixel; NaN where it cannot be measured (texture, occlusion, beyond the right
/// picture).
struct DisparityMap {
  FloatImage disparity;  ///< [px]
  FloatImage sigma;      ///< standard deviation [px]; NaN where the disparity was filled in
};

}  // namespace collinea
