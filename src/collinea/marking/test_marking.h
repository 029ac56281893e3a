// SPDX-License-Identifier: Apache-2.0
#pragma once

// Adjusted blocks with known truth, for the tests of this module only.

#include <gtest/gtest.h>

#include <memory>

#include "collinea/adjust/test_block.h"
#include "collinea/marking/predicted_marks.h"
#include "collinea/quality/examine.h"

namespace collinea::testing {

/// A block as its adjustment left it, and as it truly is; its control takes no part in the adjustment.
struct MarkingScene {
  Block truth, block;
  std::map<ImageId, std::vector<std::size_t>> observations;
  PoseCovariances poses;
  std::map<ControlId, Eigen::Vector3d> points;  ///< where control truly is
  AdjustScope scope;                            ///< of the adjustment
  Calibration calibration = Calibration::kNone;

  [[nodiscard]] MarkingBlock marking() const { return {block, observations, poses}; }
  /// With what the adjustment knows of images together.
  [[nodiscard]] MarkingBlock marking_together() const {
    MarkingBlock all = marking();
    const auto precision =
        std::make_shared<Result<BlockPrecision>>(BlockPrecision::of(block, scope, plain(calibration), {}));
    EXPECT_TRUE(*precision);
    all.poses_together = [precision](std::span<const ImageId> images) { return (*precision)->joint_poses(images); };
    return all;
  }
  /// Where an image truly shows a point; nothing when it does not.
  [[nodiscard]] std::optional<Eigen::Vector2d> seen(ImageId image, ControlId point) const {
    const auto pixel = project(truth.camera_of(image), pose_of(truth, image) * points.at(point));
    return pixel && inside(truth.camera_of(image), *pixel) ? pixel : std::nullopt;
  }
  /// A mark of a point with an error.
  [[nodiscard]] ControlObservation mark(ImageId image, ControlId point, double sigma_px, Random& random) const {
    const double du = random.normal(), dv = random.normal();
    return {point, image, *seen(image, point) + sigma_px * Eigen::Vector2d(du, dv), std::max(sigma_px, 0.01)};
  }
};

/// Control is given with `given_sigma_m`; without noise everything is exact.
inline MarkingScene marking_scene(std::uint64_t seed, bool noise = true, double given_sigma_m = 0.05,
                                  Calibration calibration = Calibration::kNone) {
  TestBlockOptions options{.rows = 3, .columns = 5, .points = 150, .control = 4, .seed = seed};
  MarkingScene scene;
  scene.truth = test_block(options);
  scene.block = scene.truth;
  Random random(seed, 17);
  for (auto& [id, point] : scene.block.control) {
    scene.points[id] = point.position_in_world;
    point.position_in_world += (noise ? given_sigma_m : 0) * normal3(random);
    point.sigma_m.setConstant(given_sigma_m);
  }
  scene.block.control_observations.clear();
  AdjustScope scope;
  scope.use_control = false;
  Block measured = measured_anew(scene.block, scope, seed);
  if (!noise) {
    measured.observations = scene.block.observations;
    for (auto& [id, image] : measured.images) image.position->position_in_world = centre_of(pose_of(scene.truth, id));
  }
  if (calibration == Calibration::kNone) scope.first_cameras.clear();
  scene.scope = scope;
  scene.calibration = calibration;
  const auto examined = examine(measured, scope, {.adjust = plain(calibration)}, {});
  if (!examined) return scene;
  apply(*examined, measured);
  scene.block = std::move(measured);
  scene.poses = examined->pose_covariance;
  scene.observations = observations_by_image(scene.block);
  return scene;
}

/// The images that see a point, in an order of chance.
inline std::vector<ImageId> images_of(const MarkingScene& scene, ControlId point, Random& random) {
  std::vector<ImageId> images;
  for (const OrientedImage& one : oriented_images(scene.truth))
    if (scene.seen(one.image, point)) images.push_back(one.image);
  for (std::size_t i = images.size(); i > 1; --i) std::swap(images[i - 1], images[random.below(std::uint32_t(i))]);
  return images;
}

}  // namespace collinea::testing
