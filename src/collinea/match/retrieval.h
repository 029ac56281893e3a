// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <vector>

#include "collinea/match/internal/look.h"

namespace collinea {

/// For each image the `options.candidates` most similar ones, by a vector of locally aggregated descriptors (VLAD,
/// Jegou et al. 2010) of its glance, on visual words found by k-means on the block itself; each word's residuals have
/// unit length (Arandjelovic and Zisserman 2013), and the vector is kept in bytes. A block of no more images than that:
/// all pairs. Sorted, each pair once. Time: images^2 * 4096 byte products, a second or two for 4000 images. Errors:
/// cancelled.
[[nodiscard]] Result<std::vector<ImageIdPair>> similar_pairs(const std::map<ImageId, Glance>& glances,
                                                             const PairOptions& options, const Run& run);

}  // namespace collinea
