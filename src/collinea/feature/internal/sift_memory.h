// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "collinea/feature/sift.h"

namespace collinea {

/// What the levels of one octave may take that are kept for the description of features: those of 26 megapixels.
/// Larger ones are made twice more, a few rows at a time.
inline constexpr std::size_t kMostKeptBytes = std::size_t{320} << 20;

/// detect_sift() with another limit: the same features.
[[nodiscard]] Features detect_sift(const GreyImage& image, const SiftOptions& options, std::size_t most_kept_bytes);

}  // namespace collinea
