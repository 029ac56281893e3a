// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <utility>
#include <vector>

#include "collinea/block/block.h"

namespace collinea {

/// Brings measurements of tie points to the order of Block::observations, those that come twice behind each other as
/// they were. `of` says which observation an element is.
template <class Seen, class Of>
void sort_by_point_and_image(std::vector<Seen>& seen, Of&& of) {
  std::stable_sort(seen.begin(), seen.end(), [&](const Seen& a, const Seen& b) {
    return std::pair(of(a).point, of(a).image) < std::pair(of(b).point, of(b).image);
  });
}

inline void sort_by_point_and_image(std::vector<Observation>& seen) {
  sort_by_point_and_image(seen, [](const Observation& one) -> const Observation& { return one; });
}

}  // namespace collinea
