// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "collinea/base/options.h"
#include "collinea/block/features.h"

namespace collinea {

struct MatchOptions {
  double max_ratio = 0.8;
  double max_distance = 0.7;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = MatchOptions;
    visit(Field{"max_ratio", &O::max_ratio, "1",
                "largest ratio of the distances to the nearest and the second nearest descriptor", 0.0, 1.0});
    visit(Field{"max_distance", &O::max_distance, "1", "largest distance of two descriptors taken as unit vectors", 0.0,
                2.0});
  }
};

/// The pairs of descriptors that are each other's nearest, by exact search, and pass the ratio test (Lowe 2004) in both
/// directions. A descriptor with two equally near ones has no match. Where a set holds one descriptor only, there is
/// no second to compare with and the distance alone decides. Sorted by the index in a.
/// Cost: count_a * count_b * 128 byte products, well below 0.1 s for 8192 x 8192 on one core with AVX-512.
[[nodiscard]] std::vector<Match> match_descriptors(std::span<const Descriptor> a, std::span<const Descriptor> b,
                                                   const MatchOptions& options);

/// match_descriptors among the pairs that may be at all: descriptor i of a with candidates[begin[i]] to
/// candidates[begin[i + 1] - 1] of b, each once. Nearest and second nearest are those among the candidates, in both
/// directions; where there is no second, one at max_distance takes its place.
[[nodiscard]] std::vector<Match> match_among(std::span<const Descriptor> a, std::span<const Descriptor> b,
                                             std::span<const std::uint32_t> begin,
                                             std::span<const std::uint32_t> candidates, const MatchOptions& options);

}  // namespace collinea
