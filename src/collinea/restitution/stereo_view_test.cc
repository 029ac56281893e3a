// SPDX-License-Identifier: Apache-2.0
#include "collinea/restitution/stereo_view.h"

#include <gtest/gtest.h>

#include "collinea/restitution/test_stereo.h"

namespace collinea {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// The strip with tie points where they truly are.
struct Scene {
  Block block = *observations_only(*make_survey(testing::strip_of_three()), {}, {});
  std::map<ImageId, std::vector<std::size_t>> observations = observations_by_image(block);
  PoseCovariances poses = {};
  [[nodiscard]] MarkingBlock marking() const { return {block, observations, poses}; }
  /// In plan, between the first two images.
  [[nodiscard]] Vector2d position() const {
    const auto images = oriented_images(block);
    return (0.5 * (centre_of(images[0].cam_from_world) + centre_of(images[1].cam_from_world))).head<2>();
  }
};

// The floating mark lies where the surface says, and both photographs show it there.
TEST(StereoView, TheMarkIsAtTheHeightOfTheSurface) {
  const Scene scene;
  const Vector2d at = scene.position();
  const MapHeight surface = [](const Vector2d&) { return std::optional(3.25); };
  const auto view = stereo_view(scene.marking(), nullptr, surface, {at, {}});
  ASSERT_TRUE(view) << view.error().message;
  EXPECT_LT((view->position_in_world - Vector3d(at.x(), at.y(), 3.25)).norm(), 1e-9);
  const auto again = view->model.position_in_world(view->mark);
  ASSERT_TRUE(again);
  EXPECT_LT((*again - view->position_in_world).norm(), 1e-6);
  const auto pixels = view->model.pixels_of(scene.block, view->mark);
  ASSERT_TRUE(pixels);
  const ImageId images[] = {view->model.left, view->model.right};
  for (std::size_t k = 0; k < 2; ++k) {
    const auto truth =
        project(scene.block.camera_of(images[k]), pose_of(scene.block, images[k]) * view->position_in_world);
    ASSERT_TRUE(truth);
    EXPECT_LT(((*pixels)[k] - *truth).norm(), 1e-3);
  }
  EXPECT_EQ(view->shown.images, view->choices.front().images);
  EXPECT_LT((view->map.at(view->position_in_world) - view->position_in_world).norm(), 1e-6);
  const Vector2d node = view->left.at(view->mark.x, view->mark.y);
  EXPECT_LT((node - (*pixels)[0]).norm(), 2 * kLatticeError_px);
}

TEST(StereoView, WithoutASurfaceTiePointsGiveTheHeight) {
  const Scene scene;
  const Vector2d at = scene.position();
  const auto view = stereo_view(scene.marking(), nullptr, {}, {at, {}});
  ASSERT_TRUE(view) << view.error().message;
  std::vector<std::pair<double, double>> near;
  for (const auto& [id, point] : scene.block.points)
    near.emplace_back((point.position_in_world.head<2>() - at).norm(), point.position_in_world.z());
  std::ranges::sort(near);
  std::vector<double> heights;
  for (std::size_t i = 0; i < kNearTies; ++i) heights.push_back(near[i].second);
  std::ranges::sort(heights);
  EXPECT_NEAR(view->position_in_world.z(), heights[kNearTies / 2], 1e-9);
  // A surface that knows nothing there is as good as none.
  const auto holed =
      stereo_view(scene.marking(), nullptr, [](const Vector2d&) { return std::optional<double>(); }, {at, {}});
  ASSERT_TRUE(holed);
  EXPECT_EQ(holed->position_in_world, view->position_in_world);
}

// Of two photographs alone the position is a tie point of both; a position that is named with them is looked at in
// them, however it is turned around.
TEST(StereoView, PhotographsThatAreNamedAreShown) {
  const Scene scene;
  const auto images = oriented_images(scene.block);
  const std::pair pair(images[1].image, images[0].image);
  const auto alone = stereo_view(scene.marking(), nullptr, {}, {{}, pair});
  ASSERT_TRUE(alone) << alone.error().message;
  bool is_tie = false;
  for (const auto& [id, point] : scene.block.points)
    is_tie |= (point.position_in_world - alone->position_in_world).norm() < 1e-9;
  EXPECT_TRUE(is_tie);
  const auto there = stereo_view(scene.marking(), nullptr, {}, {scene.position(), pair});
  ASSERT_TRUE(there) << there.error().message;
  EXPECT_EQ(std::set<ImageId>({there->model.left, there->model.right}), std::set<ImageId>({pair.first, pair.second}));
  EXPECT_NEAR(there->position_in_world.x(), scene.position().x(), 1e-9);
}

TEST(StereoView, WhatCannotBeShownIsRefused) {
  Scene scene;
  const auto images = oriented_images(scene.block);
  const auto code = [&](const AskedStereo& asked) {
    const auto view = stereo_view(scene.marking(), nullptr, {}, asked);
    return view ? std::optional<Errc>() : std::optional(view.error().code);
  };
  EXPECT_EQ(code({}), Errc::kBadInput);
  EXPECT_EQ(code({Vector2d(1e6, 0), {}}), Errc::kIllPosed);
  EXPECT_EQ(code({Vector2d(1e6, 0), std::pair(images[0].image, images[1].image)}), Errc::kIllPosed);
  EXPECT_TRUE(code({{}, std::pair(images[0].image, ImageId{999})}));
  EXPECT_TRUE(code({{}, std::pair(images[0].image, images[0].image)}));
  scene.observations.clear();  // no tie point in common
  EXPECT_EQ(code({{}, std::pair(images[0].image, images[1].image)}), Errc::kIllPosed);
  scene.block.points.clear();
  EXPECT_EQ(code({scene.position(), {}}), Errc::kIllPosed);
  for (const OrientedImage& one : images) remove_pose(scene.block, one.image);
  EXPECT_EQ(code({Vector2d(0, 0), {}}), Errc::kIllPosed);
}

}  // namespace
}  // namespace collinea
