// SPDX-License-Identifier: Apache-2.0
#include "collinea/match/descriptors.h"

#include "collinea/base/result.h"
#include "collinea/match/internal/descriptors_kernels.h"

namespace collinea {
namespace {

static_assert(sizeof(Descriptor) == 128);
constexpr double kNorm = 512;  // of a descriptor

double largest_squared(const MatchOptions& options) {
  return options.max_distance * options.max_distance * kNorm * kNorm;
}

bool is_distinct(const NearestTwo& nearest, double squared_ratio, double largest) {
  if (nearest.best == NearestTwo::kNone || nearest.best > largest) return false;
  return nearest.second == NearestTwo::kNone || nearest.best < squared_ratio * nearest.second;
}

std::vector<Match> mutual(std::span<const NearestTwo> of_a, std::span<const NearestTwo> of_b,
                          const MatchOptions& options) {
  const double squared_ratio = options.max_ratio * options.max_ratio, largest = largest_squared(options);
  std::vector<Match> matches;
  for (std::uint32_t i = 0; i < of_a.size(); ++i) {
    const std::uint32_t j = of_a[i].index;
    if (is_distinct(of_a[i], squared_ratio, largest) && of_b[j].index == i &&
        is_distinct(of_b[j], squared_ratio, largest))
      matches.emplace_back(i, j);
  }
  return matches;
}

void add(NearestTwo& nearest, std::int32_t distance, std::uint32_t index) {
  if (distance < nearest.best) {
    nearest.second = nearest.best;
    nearest.best = distance;
    nearest.index = index;
  } else if (distance < nearest.second) {
    nearest.second = distance;
  }
}

}  // namespace

std::vector<Match> match_descriptors(std::span<const Descriptor> a, std::span<const Descriptor> b,
                                     const MatchOptions& options) {
  if (a.empty() || b.empty()) return {};
  std::vector<NearestTwo> of_a(a.size()), of_b(b.size());
  nearest_two(a.front().data(), a.size(), b.front().data(), b.size(), of_a.data(), of_b.data());
  return mutual(of_a, of_b, options);
}

std::vector<Match> match_among(std::span<const Descriptor> a, std::span<const Descriptor> b,
                               std::span<const std::uint32_t> begin, std::span<const std::uint32_t> candidates,
                               const MatchOptions& options) {
  COLLINEA_CHECK(begin.size() == a.size() + 1 && begin.back() == candidates.size());
  std::vector<NearestTwo> of_a(a.size()), of_b(b.size());
  std::vector<std::int32_t> distances;
  for (std::uint32_t i = 0; i < a.size(); ++i) {
    const auto some = candidates.subspan(begin[i], begin[i + 1] - begin[i]);
    distances.resize(some.size());
    if (!some.empty()) squared_distances(a[i].data(), b.front().data(), some.data(), some.size(), distances.data());
    for (std::size_t k = 0; k < some.size(); ++k) {
      COLLINEA_CHECK(some[k] < b.size());
      add(of_a[i], distances[k], some[k]);
      add(of_b[some[k]], distances[k], i);
    }
  }
  const auto limit = static_cast<std::int32_t>(largest_squared(options));
  for (auto* nearest : {&of_a, &of_b})
    for (NearestTwo& one : *nearest)
      if (one.second == NearestTwo::kNone) one.second = limit;
  return mutual(of_a, of_b, options);
}

}  // namespace collinea
