// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

#include "collinea/base/options.h"
#include "collinea/raster/raster.h"

namespace collinea {

/// How unlike two pixels of a pair are. Census is the one to use; the others are there to be compared with it.
enum class StereoCost : std::uint8_t { kCensus, kZncc, kRank, kSad, kSsd };
inline constexpr Word<StereoCost> kStereoCostWords[] = {{StereoCost::kCensus, "census"},
                                                        {StereoCost::kZncc, "zncc"},
                                                        {StereoCost::kRank, "rank"},
                                                        {StereoCost::kSad, "sad"},
                                                        {StereoCost::kSsd, "ssd"}};
[[nodiscard]] constexpr std::span<const Word<StereoCost>> words(StereoCost) { return kStereoCostWords; }

/// Disparities to search, both ends included [px]: column in the left image less column in the right one.
struct DisparityRange {
  int low = 0, high = 63;
};

/// What the left image sees, pixel by pixel; NaN where it cannot be measured (texture, occlusion, beyond the right
/// image).
struct DisparityMap {
  FloatImage disparity;  ///< [px]
  FloatImage sigma;      ///< standard deviation [px]; NaN where the disparity was filled in
};

}  // namespace collinea
