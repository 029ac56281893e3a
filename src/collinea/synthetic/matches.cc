// SPDX-License-Identifier: Apache-2.0
#include "collinea/synthetic/matches.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "collinea/base/parallel.h"
#include "collinea/math/random.h"

namespace collinea {
namespace {

using Rays = std::map<ImageId, std::vector<Eigen::Vector3d>>;  // directions of the features in the camera frame

// The feature of `seconds` closest to the epipolar plane of `first`; never the true one.
std::uint32_t next_to_epipolar_line(const Eigen::Vector3d& first, const std::vector<Eigen::Vector3d>& seconds,
                                    std::uint32_t true_one, const Rigid3& second_from_first) {
  const Eigen::Vector3d normal = second_from_first.translation.cross(second_from_first.rotation * first).normalized();
  std::uint32_t best = true_one;
  double smallest = std::numeric_limits<double>::infinity();
  for (std::uint32_t i = 0; i < seconds.size(); ++i) {
    const double distance = std::abs(normal.dot(seconds[i]));
    if (i == true_one || distance >= smallest) continue;
    smallest = distance;
    best = i;
  }
  return best;
}

// Takes away some matches and leads some others to wrong features; no feature is matched twice.
void spoil(ImagePair& pair, const Block& block, const Rays& rays, const ObservationOptions& options) {
  Random random(options.seed + 2, (std::uint64_t{pair.first.value} << 32) + pair.second.value);
  const std::vector<Eigen::Vector3d>&first = rays.at(pair.first), &second = rays.at(pair.second);
  const Rigid3 second_from_first = pose_of(block, pair.second) * inverse(pose_of(block, pair.first));
  std::vector<Match> right, wrong;
  for (const Match& match : pair.matches) {
    if (random.uniform() >= options.matched_share) continue;
    if (random.uniform() >= options.wrong_share)
      right.push_back(match);
    else
      wrong.emplace_back(match.first,
                         next_to_epipolar_line(first[match.first], second, match.second, second_from_first));
  }
  std::vector<char> taken(second.size(), 0);
  pair.matches.clear();
  for (const auto* list : {&wrong, &right})
    for (const Match& match : *list)
      if (!std::exchange(taken[match.second], 1)) pair.matches.push_back(match);
  std::sort(pair.matches.begin(), pair.matches.end());
  pair.putative = static_cast<int>(pair.matches.size());
}

std::vector<ImagePair> true_pairs(const Block& block) {
  std::map<std::pair<ImageId, ImageId>, std::vector<Match>> matches;
  for (std::size_t begin = 0, end = 0; begin < block.observations.size(); begin = end) {
    while (end < block.observations.size() && block.observations[end].point == block.observations[begin].point) ++end;
    for (std::size_t i = begin; i < end; ++i)
      for (std::size_t k = i + 1; k < end; ++k)
        matches[{block.observations[i].image, block.observations[k].image}].emplace_back(block.observations[i].feature,
                                                                                         block.observations[k].feature);
  }
  std::vector<ImagePair> pairs;
  for (auto& [ids, list] : matches) {
    ImagePair& pair = pairs.emplace_back();
    pair.first = ids.first;
    pair.second = ids.second;
    pair.matches = std::move(list);
  }
  return pairs;
}

}  // namespace

SimulatedMatches simulated_matches(const Block& block, const ObservationOptions& options, std::size_t least_matches,
                                   const Run& run) {
  constexpr float kScale_px = 2, kStrength = 1;
  SimulatedMatches result;
  Rays rays;
  for (const Observation& seen : block.observations) {  // the features of an image are numbered in this order
    result.keypoints[seen.image].push_back(
        {static_cast<float>(seen.pixel.x()), static_cast<float>(seen.pixel.y()), kScale_px, 0, kStrength});
    rays[seen.image].push_back(ray_in_cam(block.camera_of(seen.image), seen.pixel));
  }
  result.pairs = true_pairs(block);
  const auto too_few = [&](const ImagePair& pair) { return pair.matches.size() < least_matches; };
  std::erase_if(result.pairs, too_few);
  parallel_for(run, result.pairs.size(), [&](std::size_t i) { spoil(result.pairs[i], block, rays, options); });
  std::erase_if(result.pairs, too_few);
  return result;
}

}  // namespace collinea
