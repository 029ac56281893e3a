// SPDX-License-Identifier: Apache-2.0
#include "collinea/geometry/robust_similarity.h"

#include <Eigen/Eigenvalues>
#include <array>
#include <cmath>
#include <limits>

#include "collinea/math/least_median.h"
#include "collinea/math/median.h"

namespace collinea::bundle {
namespace {

std::optional<Similarity3> fit(const std::vector<PositionPair>& pairs, const std::vector<double>& weights) {
  std::vector<Eigen::Vector3d> a, b;
  for (const PositionPair& pair : pairs) {
    a.push_back(pair.in_block);
    b.push_back(pair.in_world);
  }
  return align(a, b, weights);
}

// Pairs count fully within 27^1/2 standard deviations, beyond not at all.
std::optional<Similarity3> refined(const std::vector<PositionPair>& pairs, Similarity3 world_from_block,
                                   std::vector<double>& weights) {
  for (int round = 0; round < 10; ++round) {
    const std::vector<double> distance = distances(pairs, world_from_block);
    const double scatter = median(std::vector(distance)) / 1.54;  // median of the length of a normal 3-vector
    weights.clear();
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const double variance = pairs[i].sigma_m * pairs[i].sigma_m + scatter * scatter;
      weights.push_back(distance[i] * distance[i] <= 3 * 9 * variance ? 1 / variance : 0);
    }
    const auto next = fit(pairs, weights);
    if (!next) return std::nullopt;
    world_from_block = *next;
  }
  return world_from_block;
}

}  // namespace

bool span_a_plane(const std::vector<PositionPair>& pairs) {
  if (pairs.size() < 3) return false;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const PositionPair& pair : pairs) mean += pair.in_world / double(pairs.size());
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  double variance = 0;
  for (const PositionPair& pair : pairs) {
    spread += (pair.in_world - mean) * (pair.in_world - mean).transpose();
    variance += pair.sigma_m * pair.sigma_m / double(pairs.size());
  }
  const Eigen::Vector3d axes =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread).eigenvalues() / double(pairs.size());
  return axes[1] > 1e-6 * axes[2] && axes[1] > 4 * variance / double(pairs.size());
}

std::optional<Similarity3> best_of_triples(const std::vector<PositionPair>& pairs, std::size_t most, std::uint64_t seed,
                                           const std::function<double(const Similarity3&)>& criterion) {
  const std::size_t n = pairs.size();
  if (n < 3) return std::nullopt;
  std::optional<Similarity3> best;
  double least = std::numeric_limits<double>::infinity();
  const auto attempt = [&](std::size_t i, std::size_t j, std::size_t k) {
    const std::array<Eigen::Vector3d, 3> a{pairs[i].in_block, pairs[j].in_block, pairs[k].in_block};
    const std::array<Eigen::Vector3d, 3> b{pairs[i].in_world, pairs[j].in_world, pairs[k].in_world};
    const auto candidate = align(a, b);
    if (!candidate || !(candidate->scale > 0)) return;
    if (const double value = criterion(*candidate); value < least) {
      least = value;
      best = candidate;
    }
  };
  for_triples(n, most, seed, attempt);
  return best;
}

std::vector<double> distances(const std::vector<PositionPair>& pairs, const Similarity3& world_from_block) {
  std::vector<double> result;
  for (const PositionPair& pair : pairs) result.push_back((world_from_block * pair.in_block - pair.in_world).norm());
  return result;
}

std::optional<RobustSimilarity> robust_similarity(const std::vector<PositionPair>& pairs, std::uint64_t seed) {
  if (pairs.size() < 3) return std::nullopt;
  constexpr std::size_t kMostTriples = 500;
  const auto start = best_of_triples(pairs, kMostTriples, seed,
                                     [&](const Similarity3& candidate) { return median(distances(pairs, candidate)); });
  if (!start) return std::nullopt;
  RobustSimilarity result;
  const auto best = refined(pairs, *start, result.weights);
  if (!best) return std::nullopt;
  result.world_from_block = *best;
  result.distances_m = distances(pairs, *best);
  return result;
}

}  // namespace collinea::bundle
