// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace collinea::dense {

/// Elements that rows of patterns are padded to a multiple of (with 0), and that rows of pixels may be read beyond.
inline constexpr int kPatternUnit = 16;

/// products[x] = sum over v < side, u < pattern_width of pattern[v * pattern_width + u] * pixels[v * stride + x + u],
/// for x < columns; pattern_width is a multiple of kPatternUnit. Sums must fit into 31 bits.
void row_products(const std::int16_t* pattern, int pattern_width, int side, const std::uint8_t* pixels, int stride,
                  int columns, std::int32_t* products);

}  // namespace collinea::dense
