// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace collinea::dense {

/// What arrives at a pixel along one path: costs by label, readable from [-1] to [stride]; and the smallest of them.
struct Arriving {
  const std::uint16_t* costs;
  std::uint16_t smallest;
  std::uint16_t large;  ///< penalty of a large change on the way here
};

/// One step of `count` paths (1 to 4) into the same pixel; `stride` is a multiple of 16. For each path p, label k:
///   leaving[p][k] = cost[k] + min(arriving[k], arriving[k +- 1] + small, smallest + large) - smallest
/// and sums[k] += leaving[p][k]. smallest_leaving[p] is the minimum over k.
void step_paths(const std::uint8_t* cost, int stride, const Arriving* arriving, int count, std::uint16_t small,
                std::uint16_t* const* leaving, std::uint16_t* smallest_leaving, std::uint16_t* sums);

/// The index of the first of the least of values[from] to values[to - 1], from < to <= 32767; `values` is readable to a
/// multiple of 16.
[[nodiscard]] int first_least(const std::uint16_t* values, int from, int to);

}  // namespace collinea::dense
