// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "collinea/block/features.h"
#include "collinea/match/descriptors.h"

namespace collinea {

/// match_descriptors among the pairs that may be at all: descriptor i of a with candidates[begin[i]] to
/// candidates[begin[i + 1] - 1] of b, each once. Nearest and second nearest are those among the candidates, in both
/// directions; where there is no second, one at max_distance takes its place.
[[nodiscard]] std::vector<Match> match_among(std::span<const Descriptor> a, std::span<const Descriptor> b,
                                             std::span<const std::uint32_t> begin,
                                             std::span<const std::uint32_t> candidates, const MatchOptions& options);

}  // namespace collinea
