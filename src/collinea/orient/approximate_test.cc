// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/approximate.h"

#include <gtest/gtest.h>

#include <limits>
#include <map>

#include "collinea/geometry/rotation.h"

namespace collinea {
namespace {

// Four images over a grid of points 5 m apart, every point measured in all; the corners of the first images' field are
// control.
struct Scene {
  Block truth;

  Scene() {
    Camera camera = ideal_camera(1000, 1500, 1500);
    camera.params[Camera::kK1] = -0.05;
    truth.cameras[{0}] = camera;
    for (std::uint32_t i = 0; i < 4; ++i) {
      truth.images[{i}] = {.file = "image " + std::to_string(i), .camera = {0}};
      const Eigen::Quaterniond rotation = cam_from_world(OmegaPhiKappa{3.0 * i - 4, 5 - 2.0 * i, 40.0 * i});
      set_pose(truth, {i}, {rotation, -(rotation * Eigen::Vector3d(6.0 * i, 2.0 * (i % 2), 30))});
    }
    std::uint32_t number = 0;
    for (int x = -1; x < 6; ++x)
      for (int y = -1; y < 2; ++y) {
        const Eigen::Vector3d position(5 * x, 5 * y, 0.3 * ((x * x + 3 * y) % 5));
        truth.points[{number}] = {position, {}};
        for (std::uint32_t i = 0; i < 4; ++i)
          if (const auto pixel = project(camera, pose_of(truth, {i}) * position); pixel && inside(camera, *pixel))
            truth.observations.push_back({{i}, {number}, 0, *pixel, 1});
        ++number;
      }
  }

  // Tie points become control.
  [[nodiscard]] Block with_control(const std::vector<std::uint32_t>& points) const {
    Block block = truth;
    for (const std::uint32_t p : points) {
      const Eigen::Vector3d position = truth.points.at({p}).position_in_world;
      block.control[{p}] = {.name = std::to_string(p),
                            .role = ControlRole::kControl,
                            .position_in_map = position,
                            .position_in_world = position,
                            .sigma_m = {0.01, 0.01, 0.01}};
      for (const Observation& seen : truth.observations)
        if (seen.point == PointId{p}) block.control_observations.push_back({{p}, seen.image, seen.pixel, 1});
      std::erase_if(block.observations, [&](const Observation& seen) { return seen.point == PointId{p}; });
    }
    block.points.clear();
    clear_poses(block);
    return block;
  }
};

TEST(Approximate, FindsEveryPoseAndPointFromControlOfTheFirstImages) {
  const Scene scene;
  Block block = scene.with_control({0, 2, 4, 6, 8, 10});
  const auto found = approximate(block, 1);
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_EQ(found->resected.size(), 4u);
  EXPECT_TRUE(found->without_pose.empty());
  ASSERT_EQ(count_oriented(block), 4u);
  for (const auto& [id, pose] : oriented_images(scene.truth))
    EXPECT_LT((centre_of(pose_of(block, id)) - centre_of(pose)).norm(), 1e-5);
  EXPECT_GT(block.points.size(), 10u);
  for (const auto& [id, point] : block.points)
    EXPECT_LT((point.position_in_world - scene.truth.points.at(id).position_in_world).norm(), 1e-5);
}

// Points with names and no coordinates, and the poses of two images, are enough for the others.
TEST(Approximate, ResectsByPointsThatAreOnlyMarked) {
  const Scene scene;
  std::vector<std::uint32_t> all;
  for (const auto& [id, point] : scene.truth.points) all.push_back(id.value);
  Block block = scene.with_control(all);
  for (auto& [id, point] : block.control) {
    point.position_in_world.setConstant(std::numeric_limits<double>::quiet_NaN());
    point.sigma_m.setConstant(std::numeric_limits<double>::infinity());
  }
  ASSERT_FALSE(approximate(block, 1));
  for (const std::uint32_t i : {0u, 1u}) set_pose(block, {i}, pose_of(scene.truth, {i}));
  block.control[{99}] = block.control.at({0});
  block.control_observations.push_back({{99}, {0}, {5, 5}, 1});
  const auto found = approximate(block, 1);
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_EQ(found->resected.size(), 2u);
  EXPECT_EQ(found->marked_without_position, std::vector<ControlId>{{99}});
  for (const auto& [id, pose] : oriented_images(scene.truth))
    EXPECT_LT((centre_of(pose_of(block, id)) - centre_of(pose)).norm(), 1e-5);
}

TEST(Approximate, NamesWhatItCannotFind) {
  const Scene scene;
  Block block = scene.with_control({0, 2, 4, 6, 8, 10});
  block.images[{9}] = {.file = "far away", .camera = {0}};
  block.observations.push_back({{9}, {50}, 0, {700, 700}, 1});
  block.observations.push_back({{9}, {51}, 0, {800, 700}, 1});
  const auto found = approximate(block, 1);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->without_pose, std::vector<ImageId>{{9}});
  EXPECT_EQ(found->without_position, (std::vector<PointId>{{50}, {51}}));
}

TEST(Approximate, SaysWhenThereIsNothingToBeginAt) {
  const Scene scene;
  Block block = scene.with_control({0, 2});
  const auto found = approximate(block, 1);
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().code, Errc::kIllPosed);
  EXPECT_NE(found.error().message.find("four measured control points"), std::string::npos);
}

// What is known stays as it is given.
TEST(Approximate, LeavesGivenValuesAlone) {
  const Scene scene;
  Block block = scene.truth;
  remove_pose(block, {3});
  block.points[{0}].position_in_world += Eigen::Vector3d(0.5, 0, 0);
  const Block before = block;
  ASSERT_TRUE(approximate(block, 1));
  EXPECT_EQ(block.points.at({0}).position_in_world, before.points.at({0}).position_in_world);
  EXPECT_EQ(pose_of(block, {0}).translation, pose_of(before, {0}).translation);
  EXPECT_EQ(count_oriented(block), 4u);
}

// Of the marks of 15 control points in each image 40 % are wrong by 60 to 120 px, which is less than a tenth of the
// image's width: poses that only a limit keeps from them are bent, those by the least median or least sum are not.
TEST(Approximate, NearlyHalfOfTheMarksMayBeWrong) {
  const Scene scene;
  double bent_m = 0;
  for (const RobustStart start : {RobustStart::kTruncated, RobustStart::kLeastMedian, RobustStart::kL1}) {
    Block block = scene.with_control({0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14});
    std::map<ImageId, int> marks;
    for (ControlObservation& seen : block.control_observations)
      if (const int k = marks[seen.image]++; k % 5 < 2)
        seen.pixel += Eigen::Vector2d(k % 2 ? 60 : -120, (k * 37) % 100 - 50);
    const auto found = approximate(block, 1, start);
    ASSERT_TRUE(found) << found.error().message;
    EXPECT_EQ(count_oriented(block), 4u) << word_of(start);
    for (const auto& [id, pose] : oriented_images(block)) {
      const double off_m = (centre_of(pose) - centre_of(pose_of(scene.truth, id))).norm();
      if (start == RobustStart::kTruncated)
        bent_m = std::max(bent_m, off_m);
      else
        EXPECT_LT(off_m, 0.05) << word_of(start) << " " << id.value;
    }
  }
  EXPECT_GT(bent_m, 0.2);
}

}  // namespace
}  // namespace collinea
