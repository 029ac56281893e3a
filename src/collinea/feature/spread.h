// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace collinea {

/// A place in an image with a strength.
struct Spot {
  float x = 0, y = 0;  ///< [px]
  float strength = 0;
};

/// The order in which to take spots of an image (their indices) when `wanted` of them may be taken: first the
/// strongest, wherever they are; then, for the last even_share of the number wanted, again and again the strongest left
/// of the cell of a grid that has the fewest. Equally strong ones keep their order. All spots are in the answer: the
/// caller stops where it likes.
[[nodiscard]] std::vector<std::uint32_t> spread_order(std::span<const Spot> spots, int width, int height, int wanted,
                                                      double even_share);

}  // namespace collinea
