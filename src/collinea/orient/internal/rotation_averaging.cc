// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/internal/rotation_averaging.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>

#include "collinea/geometry/rotation.h"
#include "collinea/math/median.h"
#include "collinea/math/sparse_normals.h"

namespace collinea {
namespace {

using Quaternions = std::vector<Eigen::Quaterniond>;

constexpr int kAbsoluteRounds = 6, kRobustRounds = 10;
constexpr double kLeastAngle_rad = 1e-3;  // below it the absolute value is taken as a square: what pairs are good to
constexpr double kSettled_rad = 1e-5;

// The share of triangles over each pair that close; half for pairs that are in none. A wrong pair closes hardly any.
std::vector<double> share_of_closed_triangles(int count, std::span<const RelativeRotation> pairs) {
  constexpr double kClosed_rad = 0.05;
  std::vector<std::map<int, Eigen::Quaterniond>> other_from(static_cast<std::size_t>(count));
  for (const RelativeRotation& pair : pairs) {
    other_from[pair.first][pair.second] = pair.second_from_first;
    other_from[pair.second][pair.first] = pair.second_from_first.conjugate();
  }
  std::vector<double> shares;
  for (const RelativeRotation& pair : pairs) {
    double closed = 0.5, all = 1;
    for (const auto& [third, third_from_first] : other_from[pair.first]) {
      const auto back = other_from[pair.second].find(third);
      if (third == pair.second || back == other_from[pair.second].end()) continue;
      all += 1;
      closed += third_from_first.angularDistance(back->second * pair.second_from_first) < kClosed_rad;
    }
    shares.push_back(closed / all);
  }
  return shares;
}

// The heaviest pairs that join everything, as a walk: each pair leads from a camera reached to a new one.
Quaternions along_a_tree(int count, std::span<const RelativeRotation> pairs) {
  std::vector<std::size_t> heaviest(pairs.size());
  std::iota(heaviest.begin(), heaviest.end(), std::size_t{0});
  std::stable_sort(heaviest.begin(), heaviest.end(),
                   [&](std::size_t a, std::size_t b) { return pairs[a].weight > pairs[b].weight; });
  std::vector<int> root(static_cast<std::size_t>(count));
  std::iota(root.begin(), root.end(), 0);
  const auto find = [&](int i) {
    while (root[i] != i) i = root[i] = root[root[i]];
    return i;
  };
  std::vector<std::vector<std::size_t>> tree(static_cast<std::size_t>(count));
  for (const std::size_t pair : heaviest) {
    const int a = find(pairs[pair].first), b = find(pairs[pair].second);
    if (a == b) continue;
    root[std::max(a, b)] = std::min(a, b);
    tree[pairs[pair].first].push_back(pair);
    tree[pairs[pair].second].push_back(pair);
  }
  Quaternions rotations(static_cast<std::size_t>(count), Eigen::Quaterniond::Identity());
  std::vector<char> seen(static_cast<std::size_t>(count), 0);
  std::vector<int> open;
  for (int start = 0; start < count; ++start) {
    if (seen[start]) continue;
    seen[start] = 1;
    for (open = {start}; !open.empty();) {
      const int camera = open.back();
      open.pop_back();
      for (const std::size_t number : tree[camera]) {
        const RelativeRotation& pair = pairs[number];
        const int other = pair.first == camera ? pair.second : pair.first;
        if (seen[other]) continue;
        seen[other] = 1;
        rotations[other] =
            ((pair.first == camera ? pair.second_from_first : pair.second_from_first.conjugate()) * rotations[camera])
                .normalized();
        open.push_back(other);
      }
    }
  }
  return rotations;
}

// What turns of the cameras, w_second - w_first in the world, would satisfy the pair.
Eigen::Vector3d residual(const RelativeRotation& pair, const Quaternions& rotations) {
  return rotation_vector(rotations[pair.second].conjugate() * pair.second_from_first * rotations[pair.first]);
}

// One round: pairs weighted by their residuals, all cameras turned. Answers the largest turn.
template <class Weight>
double rotate_all(std::span<const RelativeRotation> pairs, const std::vector<Eigen::Vector3d>& residuals,
                  Weight&& weight_of, Quaternions& rotations) {
  constexpr double kTolerance = 1e-3;
  constexpr int kMostIterations = 1000;
  SparseNormals normals(rotations.size());
  for (std::size_t i = 0; i < pairs.size(); ++i)
    normals.add_difference(pairs[i].first, pairs[i].second,
                           pairs[i].weight * weight_of(residuals[i].norm()) * Eigen::Matrix3d::Identity(),
                           residuals[i]);
  std::vector<Eigen::Vector3d> angles(rotations.size(), Eigen::Vector3d::Zero());
  normals.solve(angles, kTolerance, kMostIterations);
  double largest = 0;
  for (std::size_t i = 0; i < rotations.size(); ++i) {
    largest = std::max(largest, angles[i].norm());
    rotations[i] = (rotations[i] * rotation_by(angles[i])).normalized();
  }
  return largest;
}

}  // namespace

std::vector<Eigen::Quaterniond> average_rotations(int count, std::span<const RelativeRotation> given, const Run& run) {
  std::vector<RelativeRotation> pairs(given.begin(), given.end());
  const std::vector<double> shares = share_of_closed_triangles(count, given);
  for (std::size_t i = 0; i < pairs.size(); ++i) pairs[i].weight *= shares[i] * shares[i];
  Quaternions rotations = along_a_tree(count, pairs);
  if (pairs.empty()) return rotations;
  std::vector<Eigen::Vector3d> residuals(pairs.size());
  for (int round = 0; round < kAbsoluteRounds + kRobustRounds && !run.stopped(); ++round) {
    std::vector<double> angles;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      residuals[i] = residual(pairs[i], rotations);
      angles.push_back(residuals[i].norm());
    }
    const double scale = 3 * std::max(median(angles), kLeastAngle_rad / 10);
    const double rotated =
        round < kAbsoluteRounds
            ? rotate_all(
                  pairs, residuals, [](double angle) { return 1 / std::max(angle, kLeastAngle_rad); }, rotations)
            : rotate_all(
                  pairs, residuals, [&](double angle) { return std::pow(1 + angle * angle / (scale * scale), -2); },
                  rotations);
    if (round > kAbsoluteRounds && rotated < kSettled_rad) break;
  }
  return rotations;
}

void rotate_towards(std::span<const RelativeRotation> pairs, std::span<const SeenDirection> directions,
                    std::vector<Eigen::Quaterniond>& cam_from_world, const Run& run) {
  constexpr int kRounds = 3, kMostIterations = 300;
  constexpr double kTolerance = 1e-2;
  constexpr double kPairSigma_rad =
      std::numbers::pi / 60;  // of a pair's rotation, as kDirectionSigma_rad: the same in all pairs
  const auto weight_of = [](double off_rad, double sigma_rad) {  // Cauchy's loss, scale 2
    return 1 / (sigma_rad * sigma_rad + off_rad * off_rad / 4);
  };
  for (int round = 0; round < kRounds && !run.stopped(); ++round) {
    SparseNormals normals(cam_from_world.size());
    for (const RelativeRotation& pair : pairs) {
      const Eigen::Vector3d off = residual(pair, cam_from_world);
      normals.add_difference(pair.first, pair.second,
                             weight_of(off.norm(), kPairSigma_rad) * Eigen::Matrix3d::Identity(), off);
    }
    for (const SeenDirection& seen : directions) {
      const Eigen::Vector3d now = cam_from_world[seen.camera].conjugate() * seen.in_camera;
      const Eigen::Vector3d rotation = seen.in_world.cross(now);
      const double off_rad = std::atan2(rotation.norm(), now.dot(seen.in_world));
      normals.add_value(seen.camera,
                        weight_of(off_rad, seen.sigma_rad) * (Eigen::Matrix3d::Identity() - now * now.transpose()),
                        rotation);
    }
    std::vector<Eigen::Vector3d> rotations(cam_from_world.size(), Eigen::Vector3d::Zero());
    normals.solve(rotations, kTolerance, kMostIterations);
    for (std::size_t i = 0; i < rotations.size(); ++i)
      cam_from_world[i] = (cam_from_world[i] * rotation_by(rotations[i])).normalized();
  }
}

}  // namespace collinea
