// SPDX-License-Identifier: Apache-2.0
#include "collinea/epipolar/three_images.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "collinea/epipolar/internal/essential.h"
#include "collinea/epipolar/pair_point.h"
#include "collinea/epipolar/relative_orientation.h"
#include "collinea/epipolar/spatial_parallax.h"
#include "collinea/math/median.h"

namespace collinea {
namespace {

constexpr double kAsGood = 10;  // times the scatter of the best combination
constexpr double kRounding = 1e-6;
constexpr double kParallel_rad = 1e-3;  // points of smaller parallax have no depth

// Distances along the rays of a pair: of the first image, of the second; nothing without parallax.
using Distances = std::vector<std::optional<Eigen::Vector2d>>;

Distances distances(const Rigid3& motion, std::span<const PairPoint> points) {
  Distances out;
  for (const PairPoint& point : points) {
    const auto at = spatial_parallax(motion, point.first, point.second);
    const bool has_depth = at && meeting(motion, point.first, point.second).angle_rad > kParallel_rad;
    out.push_back(has_depth ? std::optional(Eigen::Vector2d(at->along_first, at->along_second)) : std::nullopt);
  }
  return out;
}

ThreeImageCombination combination(const Distances& one, const Distances& two) {
  ThreeImageCombination out;
  std::vector<double> ratios;
  for (std::size_t i = 0; i < one.size(); ++i) {
    if (!one[i] || !two[i]) continue;
    ratios.push_back(one[i]->y() / two[i]->x());
    out.in_front += one[i]->minCoeff() > 0 && two[i]->minCoeff() > 0;
  }
  out.base_ratio = median(ratios);
  std::vector<double> deviations;
  bool has_one_sign = true;
  for (const double ratio : ratios) {
    deviations.push_back(std::abs(ratio / out.base_ratio - 1));
    has_one_sign &= ratio * out.base_ratio > 0;
  }
  out.scatter = median(std::move(deviations));
  out.is_joined = has_one_sign && out.base_ratio > 0;
  return out;
}

int count_with_depth(const Distances& one, const Distances& two) {
  int count = 0;
  for (std::size_t i = 0; i < one.size(); ++i) count += one[i] && two[i];
  return count;
}

}  // namespace

std::optional<ThreeImages> join_three_images(const Rigid3& second_from_first, const Rigid3& third_from_second,
                                             std::span<const TriplePoint> points) {
  std::vector<PairPoint> first_pair, second_pair;
  for (const TriplePoint& point : points) {
    first_pair.push_back({point.first, point.second});
    second_pair.push_back({point.second, point.third});
  }
  const auto first_four = relative_solutions(second_from_first, first_pair),
             second_four = relative_solutions(third_from_second, second_pair);
  ThreeImages out;
  double least = std::numeric_limits<double>::infinity();
  int with_depth = 0;
  for (int k = 0; k < 16; ++k) {
    const Distances one = distances(first_four[static_cast<std::size_t>(k / 4)].second_from_first, first_pair),
                    two = distances(second_four[static_cast<std::size_t>(k % 4)].second_from_first, second_pair);
    if (count_with_depth(one, two) < 2) return std::nullopt;
    ThreeImageCombination& entry = out.combinations[static_cast<std::size_t>(k)];
    entry = combination(one, two);
    entry.of_first = k / 4;
    entry.of_second = k % 4;
    least = std::min(least, entry.scatter);
    with_depth = std::max(with_depth, count_with_depth(one, two));
  }
  const ThreeImageCombination* chosen = nullptr;
  for (ThreeImageCombination& entry : out.combinations) {
    entry.is_joined = entry.is_joined && entry.scatter <= kAsGood * least + kRounding;
    if (entry.is_joined && (!chosen || entry.in_front > chosen->in_front)) chosen = &entry;
  }
  if (!chosen || 2 * chosen->in_front <= with_depth) return std::nullopt;
  out.chosen = 4 * chosen->of_first + chosen->of_second;
  out.second_from_first = first_four[static_cast<std::size_t>(chosen->of_first)].second_from_first;
  Rigid3 third = second_four[static_cast<std::size_t>(chosen->of_second)].second_from_first;
  third.translation = third.translation.normalized() * chosen->base_ratio;
  out.third_from_first = third * out.second_from_first;
  return out;
}

}  // namespace collinea
