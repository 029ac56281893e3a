// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "collinea/geometry/similarity3.h"

namespace collinea::bundle {

/// A position known in the block's frame and in the world.
struct PositionPair {
  Eigen::Vector3d in_block, in_world;
  double sigma_m = 1;  ///< of one coordinate in the world
};

struct RobustSimilarity {
  Similarity3 world_from_block;
  std::vector<double> weights;      ///< 0: an outlier
  std::vector<double> distances_m;  ///< left after the similarity
};

/// True when three or more positions do not lie on a line: the second axis of their spread is more than uncertainty.
[[nodiscard]] bool span_a_plane(const std::vector<PositionPair>& pairs);

/// Least median of squares over triples, then least squares of those whose distance is within 27^1/2 = 5.2 robust
/// standard deviations of one coordinate and their own (three on each of three axes). Nothing with fewer than three
/// pairs or when those that agree lie on one line.
[[nodiscard]] std::optional<RobustSimilarity> robust_similarity(const std::vector<PositionPair>& pairs,
                                                                std::uint64_t seed);

/// Of the similarities of all triples of positions (of `most` drawn ones where there are more) that with the least
/// criterion; nothing when none has one.
[[nodiscard]] std::optional<Similarity3> best_of_triples(const std::vector<PositionPair>& pairs, std::size_t most,
                                                         std::uint64_t seed,
                                                         const std::function<double(const Similarity3&)>& criterion);

[[nodiscard]] std::vector<double> distances(const std::vector<PositionPair>& pairs,
                                            const Similarity3& world_from_block);

}  // namespace collinea::bundle
