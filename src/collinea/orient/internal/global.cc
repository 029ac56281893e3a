// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/internal/global.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "collinea/orient/internal/incremental.h"
#include "collinea/orient/internal/position_averaging.h"
#include "collinea/orient/internal/rotation_averaging.h"

namespace collinea {
namespace {

constexpr std::size_t kManyImages = 300;  // fewer are grown as fast, and growth looks more closely at each
constexpr double kNearlyAll = 0.9;        // of the images have a position
// Tolerances of the rounds over the final one. The first is what a degree of a pair's direction makes of a point's
// image.
constexpr std::array<double, 4> kTolerances = {16, 6, 2, 1};
constexpr double kLeastLocated = 0.5;  // of the part's images must hold, or the positions contradict the pairs

/// The images of the part and what its pairs say, by the images' numbers in the part.
struct Part {
  std::vector<ImageId> images;
  std::vector<RelativeRotation> rotations;
  std::vector<RelativeDirection> directions;    // in the frame of the first camera
  std::vector<Eigen::Vector3d> seen_by_second;  // the same directions in the frame of the second
};

std::vector<ImageId> largest_part(const std::vector<ImageId>& images, std::span<const ImagePair> pairs) {
  std::map<ImageId, ImageId> root;
  for (const ImageId image : images) root[image] = image;
  const auto find = [&](ImageId i) {
    while (root.at(i) != i) i = root.at(i) = root.at(root.at(i));
    return i;
  };
  for (const ImagePair& pair : pairs) {
    if (pair.geometry == PairGeometry::kNone || !root.contains(pair.first) || !root.contains(pair.second)) continue;
    const ImageId a = find(pair.first), b = find(pair.second);
    root[std::max(a, b)] = std::min(a, b);
  }
  std::map<ImageId, std::vector<ImageId>> parts;
  for (const ImageId image : images) parts[find(image)].push_back(image);
  const auto largest = std::max_element(parts.begin(), parts.end(),
                                        [](const auto& a, const auto& b) { return a.second.size() < b.second.size(); });
  return largest == parts.end() ? std::vector<ImageId>{} : largest->second;
}

Part part_of(const std::vector<ImageId>& images, std::span<const ImagePair> pairs) {
  Part part{images, {}, {}};
  std::map<ImageId, int> number;
  for (std::size_t i = 0; i < images.size(); ++i) number[images[i]] = static_cast<int>(i);
  for (const ImagePair& pair : pairs) {
    const auto first = number.find(pair.first), second = number.find(pair.second);
    if (pair.geometry == PairGeometry::kNone || first == number.end() || second == number.end()) continue;
    const bool moves = pair.second_from_first.translation.norm() > 0;
    if (!moves && pair.geometry != PairGeometry::kRotation) continue;  // no motion was found
    part.rotations.push_back({first->second, second->second, pair.second_from_first.rotation,
                              std::sqrt(static_cast<double>(pair.matches.size()))});
    if (!moves) continue;
    const Eigen::Vector3d direction = centre_of(pair.second_from_first).normalized();
    part.directions.push_back({first->second, second->second, direction});
    part.seen_by_second.push_back(pair.second_from_first.rotation * direction);
  }
  return part;
}

std::vector<ReceivedPosition> received_by(const Part& part, const Block& setup) {
  std::vector<ReceivedPosition> received;
  for (const ImageId image : part.images) {
    const auto& position = setup.images.at(image).position;
    received.push_back(position ? ReceivedPosition{position->position_in_world, position->sigma_m}
                                : ReceivedPosition{});
  }
  return received;
}

// The bases between cameras as each of the two sees them and as the receivers have them.
std::vector<SeenDirection> bases_of(const Part& part, const std::vector<Eigen::Vector3d>& in_first,
                                    const std::vector<ReceivedPosition>& received) {
  std::vector<SeenDirection> bases;
  for (std::size_t i = 0; i < part.directions.size(); ++i) {
    const RelativeDirection& pair = part.directions[i];
    const ReceivedPosition &first = received[pair.first], &second = received[pair.second];
    const Eigen::Vector3d base = second.position_in_world - first.position_in_world;
    const double sigma_m = std::sqrt((first.sigma_m.squaredNorm() + second.sigma_m.squaredNorm()) / 3);
    if (!std::isfinite(sigma_m) || !(base.norm() > 0)) continue;
    const double sigma_rad = std::hypot(sigma_m / base.norm(), kDirectionSigma_rad);
    bases.push_back({pair.first, in_first[i], base.normalized(), sigma_rad});
    bases.push_back({pair.second, part.seen_by_second[i], base.normalized(), sigma_rad});
  }
  return bases;
}

// Poses in the world of the positions; nothing when these do not fix the attitude of the whole.
std::optional<std::map<ImageId, Rigid3>> poses_of(Part part, const Block& setup, const Run& run) {
  const std::vector<ReceivedPosition> received = received_by(part, setup);
  std::vector<Eigen::Quaterniond> rotations =
      average_rotations(static_cast<int>(part.images.size()), part.rotations, run);
  std::vector<Eigen::Vector3d> in_first;
  for (RelativeDirection& pair : part.directions) {
    in_first.push_back(pair.direction);
    pair.direction = rotations[pair.first].conjugate() * pair.direction;
  }
  const auto world_from_frame = world_from_directions(part.directions, received);
  if (!world_from_frame) return std::nullopt;
  for (Eigen::Quaterniond& rotation : rotations) rotation = (rotation * world_from_frame->conjugate()).normalized();
  for (RelativeDirection& pair : part.directions) pair.direction = *world_from_frame * pair.direction;
  rotate_towards(part.rotations, bases_of(part, in_first, received), rotations, run);
  for (std::size_t i = 0; i < in_first.size(); ++i)
    part.directions[i].direction = rotations[part.directions[i].first].conjugate() * in_first[i];
  const std::vector<Eigen::Vector3d> centres = average_positions(part.directions, received, run);
  std::map<ImageId, Rigid3> poses;
  for (std::size_t i = 0; i < part.images.size(); ++i)
    poses[part.images[i]] = {rotations[i], -(rotations[i] * centres[i])};
  return poses;
}

}  // namespace

bool worth_global(const Block& setup) {
  const auto positions = std::count_if(setup.images.begin(), setup.images.end(),
                                       [](const auto& image) { return image.second.position.has_value(); });
  return setup.georeference && setup.images.size() >= kManyImages &&
         static_cast<double>(positions) >= kNearlyAll * static_cast<double>(setup.images.size());
}

Result<bool> orient_globally(Reconstruction& block, const Block& setup, std::span<const ImagePair> pairs,
                             const OrientOptions& options, const Run& run) {
  const std::vector<ImageId> images = largest_part(block.images_with_tracks(), pairs);
  const auto poses = poses_of(part_of(images, pairs), setup, run);
  if (run.stopped()) return fail(Errc::kCancelled, "stopped");
  if (!poses) return false;
  block.start_from_poses(*poses);
  for (std::size_t round = 0; round < kTolerances.size(); ++round) {
    block.set_max_error_px(kTolerances[round] * options.max_error_px);
    block.extend_all(run);
    AdjustOptions adjust = settled_options(block, options);
    adjust.max_iterations = 10;
    adjust.relative_cost_change = 1e-2;
    if (round > 0) adjust.first_damping = kSettledDamping;
    if (auto adjusted = block.adjust_all(adjust, {.use_control = false, .use_geodetic = false}, run); !adjusted) {
      if (run.stopped()) return tl::unexpected(adjusted.error());
      block.forget();
      block.set_max_error_px(options.max_error_px);
      return false;
    }
    block.filter(kTolerances[round] * options.max_error_px, run);
    run.report("orient", double(round + 1) / double(kTolerances.size() + 1));
  }
  block.extend_all(run);
  block.drop_loose(options.min_points);
  if (static_cast<double>(block.poses().size()) >= kLeastLocated * static_cast<double>(images.size())) return true;
  block.forget();
  return false;
}

}  // namespace collinea
