// SPDX-License-Identifier: Apache-2.0
#pragma once

// What matching would hand over for a block with known truth, for the tests of this module only.

#include <map>
#include <vector>

#include "collinea/adjust/test_block.h"
#include "collinea/orient/orient.h"

namespace collinea::testing {

/// The input of orient() made from a block, and the block.
struct Matched {
  Block truth;
  Block setup;  ///< cameras as EXIF would give them, no poses, no points
  std::vector<ImagePair> pairs;
  std::map<ImageId, std::vector<Keypoint>> keypoints;

  [[nodiscard]] KeypointSource source() const {
    return [this](ImageId image) -> Result<std::vector<Keypoint>> { return keypoints.at(image); };
  }
};

inline std::map<ImageId, Rigid3> poses_of(const Block& block) {
  std::map<ImageId, Rigid3> poses;
  for (const auto& [image, pose] : oriented_images(block)) poses[image] = pose;
  return poses;
}

inline Keypoint keypoint_at(const Eigen::Vector2d& pixel) {
  return {static_cast<float>(pixel.x()), static_cast<float>(pixel.y()), 2, 0, 1};
}

/// Pairs of all images that share at least 20 points, with the true relative orientation.
inline Matched matched(const Block& truth) {
  Matched result{truth, truth, {}, {}};
  clear_poses(result.setup);
  result.setup.points.clear();
  result.setup.observations.clear();
  for (auto& [id, camera] : result.setup.cameras) {
    const std::string name = camera.name;
    camera = ideal_camera(1.02 * camera.focal_px(), camera.width_px, camera.height_px);
    camera.prior.sigma_f_px = 0.05 * camera.focal_px();
    camera.name = name;
  }
  std::map<std::pair<ImageId, ImageId>, std::vector<Match>> matches;
  std::vector<std::pair<ImageId, std::uint32_t>> of_point;
  PointId last;
  for (const Observation& seen : truth.observations) {  // sorted by point
    if (seen.point != last) of_point.clear();
    last = seen.point;
    auto& keypoints = result.keypoints[seen.image];
    const auto feature = static_cast<std::uint32_t>(keypoints.size());
    keypoints.push_back(keypoint_at(seen.pixel));
    for (const auto& [image, other] : of_point) matches[{image, seen.image}].emplace_back(other, feature);
    of_point.emplace_back(seen.image, feature);
  }
  for (auto& [ids, list] : matches) {
    if (list.size() < 20) continue;
    ImagePair pair{ids.first, ids.second};
    pair.geometry = PairGeometry::kGeneral;
    pair.putative = static_cast<int>(list.size());
    pair.matches = std::move(list);
    pair.second_from_first = pose_of(truth, ids.second) * inverse(pose_of(truth, ids.first));
    pair.median_parallax_rad = 0.2;
    pair.second_from_first.translation.normalize();
    result.pairs.push_back(std::move(pair));
  }
  return result;
}

/// Two strips of four images; a pixel covers 4 cm of ground.
inline Block small_block(double sigma_px = 0.5, int control = 0, double position_sigma_m = 0) {
  return test_block({.rows = 2,
                     .columns = 4,
                     .points = 500,
                     .sigma_px = sigma_px,
                     .position_sigma_m = position_sigma_m,
                     .control = control,
                     .seed = 3});
}

/// One strip, flown straight, with the attitudes a gimbal would write.
inline Block straight_strip() {
  Block block = test_block(
      {.rows = 1, .columns = 12, .points = 800, .sigma_px = 0.5, .position_sigma_m = 3, .tilt_rad = 0, .seed = 4});
  for (auto& [id, image] : block.images) image.attitude = AttitudePrior{90, -90, 0};
  return block;
}

inline constexpr double kPixel_m = 60.0 / 1500;

/// Two blocks without anything in common, as one; the ids of the second are shifted.
inline Block side_by_side(Block first, const Block& second, std::uint32_t shift = 1000) {
  for (const auto& [id, image] : second.images) first.images[ImageId{id.value + shift}] = image;
  for (const auto& [id, pose] : oriented_images(second)) set_pose(first, ImageId{id.value + shift}, pose);
  for (const auto& [id, point] : second.points) first.points[PointId{id.value + 10 * shift}] = point;
  for (Observation seen : second.observations) {
    seen.image.value += shift;
    seen.point.value += 10 * shift;
    first.observations.push_back(seen);
  }
  return first;
}

/// Root mean square distance of the projection centres from the truth [m]; as they lie, or after the similarity that
/// fits best.
inline double centre_rms_m(const Block& block, const Block& truth, bool aligned) {
  std::vector<Eigen::Vector3d> found, exact;
  for (const auto& [image, pose] : oriented_images(block)) {
    found.push_back(centre_of(pose));
    exact.push_back(centre_of(pose_of(truth, image)));
  }
  const Similarity3 truth_from_block = aligned ? align(found, exact).value() : Similarity3{};
  double sum = 0;
  for (std::size_t i = 0; i < found.size(); ++i) sum += (truth_from_block * found[i] - exact[i]).squaredNorm();
  return std::sqrt(sum / static_cast<double>(found.size()));
}

}  // namespace collinea::testing
