// SPDX-License-Identifier: Apache-2.0
#include "collinea/match/descriptors.h"

#include "collinea/match/descriptors_kernels.h"

namespace collinea {
namespace {

constexpr double kNorm = 512;  // of a descriptor

bool is_distinct(const NearestTwo& nearest, double squared_ratio, double largest) {
  if (nearest.best == NearestTwo::kNone || nearest.best > largest) return false;
  return nearest.second == NearestTwo::kNone || nearest.best < squared_ratio * nearest.second;
}

}  // namespace

std::vector<Match> match_descriptors(std::span<const Descriptor> a, std::span<const Descriptor> b,
                                     const MatchOptions& options) {
  static_assert(sizeof(Descriptor) == 128);
  if (a.empty() || b.empty()) return {};
  std::vector<NearestTwo> of_a(a.size()), of_b(b.size());
  nearest_two(a.front().data(), a.size(), b.front().data(), b.size(), of_a.data(), of_b.data());

  const double squared_ratio = options.max_ratio * options.max_ratio;
  const double largest = options.max_distance * options.max_distance * kNorm * kNorm;
  std::vector<Match> matches;
  for (std::uint32_t i = 0; i < a.size(); ++i) {
    const std::uint32_t j = of_a[i].index;
    if (is_distinct(of_a[i], squared_ratio, largest) && of_b[j].index == i &&
        is_distinct(of_b[j], squared_ratio, largest))
      matches.emplace_back(i, j);
  }
  return matches;
}

}  // namespace collinea
