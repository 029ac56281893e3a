// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/internal/strongest_first.h"

#include <algorithm>
#include <functional>
#include <numeric>

namespace collinea {

Features strongest_first(const Features& features) {
  std::vector<std::uint32_t> order(features.keypoints.size());
  std::iota(order.begin(), order.end(), 0u);
  std::ranges::stable_sort(order, std::ranges::greater{},
                           [&](std::uint32_t i) { return features.keypoints[i].strength; });
  Features sorted;
  sorted.keypoints.reserve(order.size());
  sorted.descriptors.reserve(order.size());
  for (const std::uint32_t i : order) {
    sorted.keypoints.push_back(features.keypoints[i]);
    sorted.descriptors.push_back(features.descriptors[i]);
  }
  return sorted;
}

}  // namespace collinea
